"""The report of a sweep: one self-contained page."""

from __future__ import annotations

import html
import itertools
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.format.errors import ScenarioError
from scenarios.judge.verdicts import FAILED, PASSED, UNJUDGED
from scenarios.report.summary import Summary
from scenarios.runner import run as run_into_folder
from scenarios.sweep.charts import (
    CONFIDENCE,
    Axis,
    Draw,
    as_png,
    as_svg,
    contour,
    figure_of,
    histogram,
    interval,
    scatter,
    success_map,
)
from scenarios.sweep.dataset import Dataset
from scenarios.sweep.plan import Plan

PLAYBACKS = "playbacks"
_LISTED = 10  # runs in the tables of the best, the worst and those without figures
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 76em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 0.6em 0 1.4em } th { text-align: left }
td, th { padding: 0.15em 0.8em; border-bottom: 1px solid #ddd }
svg { max-width: 100%; height: auto }
code { white-space: nowrap }
td.number { text-align: right; font-variant-numeric: tabular-nums }"""


@dataclass(frozen=True)
class Results:
    """The rows of a sweep as columns, in the order of the runs."""

    plan: Plan
    columns: dict[str, list[Any]]

    @classmethod
    def load(cls, folder: Path) -> Results:
        """Read a sweep's folder; ScenarioError if it holds none, or nothing yet."""
        dataset = Dataset.load(folder)
        table = dataset.read()
        if not table.num_rows:
            raise ScenarioError(f"{folder}: holds no rows yet")
        return cls(dataset.plan, table.to_pydict())

    @property
    def passed(self) -> NDArray[np.bool_]:
        """Which runs passed."""
        return np.array([verdict == PASSED for verdict in self.columns["verdict"]])

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Which runs reached their end and were measured."""
        known = {PASSED, FAILED, UNJUDGED}
        return np.array([verdict in known for verdict in self.columns["verdict"]])

    def numbers(self, column: str) -> NDArray[np.float64]:
        """Return a column of numbers, NaN where there is none."""
        return np.array([np.nan if v is None else v for v in self.columns[column]], dtype=float)

    def axis(self, name: str, bins: int = 0) -> Axis:
        """Return a column as an axis; unless said, with a dozen runs in a cell of a map."""
        several = int(np.clip(np.sqrt(len(self.passed) / 12), 2, 8))
        return Axis(name, self.columns[name], bins or several)

    def ranked(self) -> list[int]:
        """Return the rows with a score, the best first.

        Better is what passed; then what is further on the side of the score's limit.
        """
        score, plan = self.numbers(self.plan.score), self.plan
        limit = plan.scenario.acceptance.limits.get(plan.score)
        sign = -1.0 if limit is not None and limit.at_least is None and limit.at_most else 1.0
        centre = limit.near if limit is not None and limit.near is not None else None
        merit = -np.abs(score - centre) if centre is not None else sign * score
        rows = [row for row in range(len(score)) if np.isfinite(score[row])]
        return sorted(rows, key=lambda row: (not self.passed[row], -merit[row]))

    def named(self, wanted: str) -> int:
        """Return the row that "best", "worst", "failed" or the number of a run means."""
        ranked = self.ranked()
        broken = [row for row in range(len(self.judged)) if not self.judged[row]]
        failed = broken or [row for row in ranked if not self.passed[row]]
        choices = {"best": ranked[:1], "worst": ranked[-1:], "failed": failed[:1]}
        if wanted in choices:
            found = choices[wanted]
        else:
            found = [i for i, number in enumerate(self.columns["run"]) if str(number) == wanted]
        if not found:
            raise ScenarioError(
                f"no run is meant by '{wanted}'; say best, worst, failed or the number of a run"
            )
        return found[0]


def write_report(folder: Path) -> Path:
    """Write `report.html`, and `success.png` of its first map, into a sweep's folder."""
    results = Results.load(folder)
    maps = list(_maps(results))
    drawn = [
        _section("Success", _rates(results)),
        *(_section(title, as_svg(figure_of(*panels))) for title, panels in maps),
        _section("Figures", *(_distribution(results, name) for name in results.plan.figures)),
        _section("Best and worst", _ranking(folder, results)),
        _section("Without figures", _broken(folder, results)),
        _section("How", _provenance(results)),
    ]
    title = html.escape(f"{results.plan.name}: {len(results.passed)} runs")
    said = html.escape(results.plan.study.description)
    page = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style><h1>{title}</h1><p>{said}</p>{''.join(drawn)}</html>"
    )
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    if maps:
        as_png(figure_of(maps[0][1][0], width=6.0, height=4.4), folder / "success.png")
    return path


def simulate_again(folder: Path, wanted: str) -> Summary:
    """Run a row's simulation again, into a run folder with playback; see `Results.named`."""
    results = Results.load(folder)
    number = results.columns["run"][results.named(wanted)]
    planned = results.plan.run_of(number)
    name = f"run-{number}"
    return run_into_folder(
        name,
        results.plan.base.load(planned.overrides),
        folder / PLAYBACKS / name,
        replace=True,
        overrides=planned.overrides,
    )


def _maps(results: Results) -> Iterable[tuple[str, list[Draw]]]:
    parameters = results.plan.study.parameters
    numbers = [name for name, parameter in parameters.items() if not parameter.choices]
    pairs = results.plan.study.maps or map(list, itertools.combinations(numbers[:3], 2))
    for a, b in pairs:
        x, y = results.axis(a), results.axis(b)
        panels = [success_map(x, y, results.passed)]
        panels.append(scatter(x, y, results.passed, results.judged))
        if results.plan.score and not (x.names or y.names):
            panels.append(contour(x, y, results.numbers(results.plan.score), results.plan.score))
        yield f"{a} and {b}", panels


def _rates(results: Results) -> str:
    """Return the rate of success of all runs, and by each parameter."""
    rows = [["all", "", *_rate(results.passed)]]
    for name in results.plan.study.parameters:
        axis = results.axis(name, 4)
        rows += [
            [name, axis.label(index), *_rate(results.passed[axis.bins == index])]
            for index in range(len(axis.edges) - 1)
        ]
    return _table(["", "", "passed", "runs", "rate", f"{100 * CONFIDENCE:.0f} % interval"], rows)


def _rate(passed: NDArray[np.bool_]) -> list[str]:
    k, n = int(passed.sum()), len(passed)
    low, high = interval(k, n)
    rate = f"{100 * k / n:.1f} %" if n else "–"
    return [str(k), str(n), rate, f"{100 * low:.1f} to {100 * high:.1f} %"]


def _distribution(results: Results, name: str) -> str:
    values = results.numbers(name)
    known = values[np.isfinite(values)]
    if not len(known):
        return f"<p>{html.escape(name)}: no run has it</p>"
    quantiles = ", ".join(f"{q:.4g}" for q in np.quantile(known, [0.05, 0.5, 0.95]))
    said = html.escape(f"{name}: 5 %, median and 95 % are {quantiles}")
    return f"<p>{said}</p>{as_svg(figure_of(histogram(values, name)))}"


def _ranking(folder: Path, results: Results) -> str:
    if not results.plan.score:
        return "<p>the scenario has no figures</p>"
    ranked = results.ranked()
    chosen = [*ranked[:_LISTED], *ranked[_LISTED:][-_LISTED:]]
    names = [*results.plan.study.parameters, *results.plan.figures]
    said = "<p>A playback is made by <code>contact-toolkit report DIR --playback RUN</code>.</p>"
    return said + _table(
        ["run", "verdict", *names, "playback"],
        [
            [
                str(results.columns["run"][row]),
                results.columns["verdict"][row],
                *(_shown(results.columns[name][row]) for name in names),
                _playback(folder, results, row),
            ]
            for row in chosen
        ],
    )


def _broken(folder: Path, results: Results) -> str:
    rows = [row for row in range(len(results.judged)) if not results.judged[row]]
    if not rows:
        return "<p>none</p>"
    reasons = Counter(str(results.columns["reason"][row]) for row in rows).most_common(_LISTED)
    first = [
        [
            str(results.columns["run"][row]),
            results.columns["verdict"][row],
            results.columns["reason"][row],
            _playback(folder, results, row),
        ]
        for row in rows[:_LISTED]
    ]
    return _table(["reason", "runs"], [[said, str(n)] for said, n in reasons]) + _table(
        ["run", "verdict", "reason", "playback"], first
    )


def _playback(folder: Path, results: Results, row: int) -> Markup:
    """Return a link to the playback of a row, or the command that makes it."""
    number = results.columns["run"][row]
    made = Path(PLAYBACKS) / f"run-{number}" / "playback.html"
    if (folder / made).is_file():
        return Markup(f'<a href="{made.as_posix()}">playback</a>')
    return Markup(f"<code>--playback {number}</code>")


def _provenance(results: Results) -> str:
    plan, times = results.plan, results.numbers("wall_time")
    rows = [
        ["scenario", f"{plan.base.name} of {plan.base.path}"],
        ["sampling", f"{plan.study.sampling}, seed {plan.study.random_seed}"],
        ["versions", "; ".join(sorted(set(results.columns["versions"])))],
        [
            "wall-clock of a run",
            f"median {np.nanmedian(times):.3g} s, longest {np.nanmax(times):.3g} s",
        ],
    ]
    return _table(["", ""], rows)


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def _section(title: str, *contents: str) -> str:
    return f"<h2>{html.escape(title)}</h2>{''.join(contents)}"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(text)}</th>" for text in heads)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _cell(text: str) -> str:
    kind = ' class="number"' if text[:1].isdigit() or text[:2].strip("-.").isdigit() else ""
    return f"<td{kind}>{text if isinstance(text, Markup) else html.escape(text)}</td>"


def _shown(value: Any) -> str:
    return "–" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
