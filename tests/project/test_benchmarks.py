"""The benchmarks run on small meshes, and agree with coal and FCL about the answers; no times."""

import json
import math

import numpy as np
import pytest
import trimesh

from benchmarks.__main__ import BENCHMARKS
from benchmarks.attitudes import each_with_itself_and_the_next, parts_in_folder
from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import all_pairs
from benchmarks.plots import plot_growth, plot_ratios
from benchmarks.real_parts import measure_pairs
from benchmarks.report import write_results
from benchmarks.witness_cold import require_same_pairs
from benchmarks.yardsticks import Coal
from contact_toolkit import _core, distance, witness_pairs
from scenarios.parts import bumpy_sphere

NEEDS = {"real_parts": ["OCP"], "point_distances": ["open3d", "igl"]}  # not in the test extra


@pytest.mark.parametrize("name", BENCHMARKS)
def test_benchmark_measures_something(name):
    for package in NEEDS.get(name, []):
        pytest.importorskip(package)
    rows = list(BENCHMARKS[name].measure(Stopwatch(runs=1), coarser=6))
    assert rows
    assert all(math.isfinite(row.ratio) and row.ratio > 0 for row in rows)
    assert len({(row.benchmark, row.case) for row in rows}) == len(rows)


@pytest.mark.parametrize("pair", all_pairs(coarser=6), ids=lambda pair: pair.name)
def test_pairs_are_close_but_do_not_cross(pair):
    # Crossing surfaces have distance 0, which every engine finds early: nothing would be measured.
    A, B = pair.meshes()
    for X_AB in pair.poses.values():
        assert 0.0 < distance(A, B, X_AB).distance < 2 * min(pair.standoffs)


def test_unlike_facet_pairs_are_noticed():
    pair = all_pairs(coarser=6)[0]
    A, B = pair.meshes()
    X_AB, coal = pair.poses["tilted"], Coal(pair.B, pair.A)  # the wrong way round
    with pytest.raises(AssertionError, match="coal"):
        require_same_pairs(A, B, X_AB, 0.004, coal)


def test_kernel_alone_gives_the_distances_of_the_query():
    pair = all_pairs(coarser=6)[1]
    A, B = pair.meshes()
    X_AB = pair.poses["screwed, tilted"]
    rows = witness_pairs(A, B, X_AB, 0.0002, merge=False)
    alone = _core.facet_distances(A._core, B._core, X_AB, rows.facet_a, rows.facet_b)
    np.testing.assert_array_equal(alone, rows.distance)
    with pytest.raises(IndexError):
        _core.facet_distances(A._core, B._core, X_AB, rows.facet_a - 2**20, rows.facet_b)


def test_any_folder_of_meshes_can_be_measured(tmp_path, capsys):
    vertices, faces = bumpy_sphere(frequency=3)
    for name in ("a.obj", "b.stl"):
        trimesh.Trimesh(vertices, faces).export(tmp_path / name)
    (tmp_path / "notes.txt").write_text("no mesh")
    pairs = list(each_with_itself_and_the_next(parts_in_folder(tmp_path)))
    assert [pair.name for pair in pairs] == ["a on itself", "a and b", "b on itself", "b and a"]
    assert "notes.txt is left out" in capsys.readouterr().out
    rows = list(measure_pairs(Stopwatch(runs=1), pairs[:1]))
    assert {row.benchmark for row in rows} >= {"real parts, witness pairs", "real parts, distance"}


def test_calls_take_turns_and_the_median_counts():
    ticks = iter([0.0, 3.0, 3.0, 5.0, 5.0, 6.0, 6.0, 16.0, 16.0, 18.0, 18.0, 38.0])
    order = []
    watch = Stopwatch(runs=3, clock=lambda: next(ticks))
    watch._repeats = lambda _: 1
    medians = watch.medians(lambda: order.append("a"), lambda: order.append("b"))
    assert order == list("ababab")
    assert medians == [2.0, 10.0]


def test_results_hold_the_ratios_and_say_what_was_missed(tmp_path):
    rows = [
        Row("distance", "a on b, tilted", "coal", 1e-5, 4e-5, target=3.0, size=100, output=1),
        Row("growth", "distance, 50 facets each", "coal", 2e-5, 4e-5, target=3.0, size=100),
        Row("distance", "a on b, beside", "coal", 1e-5, 5e-5),
    ]
    write_results(rows, Stopwatch(), tmp_path)
    recorded = json.loads((tmp_path / "results.json").read_text())
    assert [row["ratio"] for row in recorded["rows"]] == pytest.approx([4.0, 2.0, 5.0])
    table = (tmp_path / "RESULTS.md").read_text()
    assert "| a on b, tilted | 100 | 1 | 10 µs | coal | 40 µs | 4.00 | 3 |" in table
    assert "**2.00**" in table
    assert table.count("## Distance") == 1  # one table, even of rows measured by turns
    for draw, name in ((plot_ratios, "ratios.png"), (plot_growth, "growth.png")):
        draw(rows, tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000
