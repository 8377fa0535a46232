"""Run one scenario under every engine there is: a table, a plot, a playback side by side."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from scenarios.compare.apart import run_apart
from scenarios.compare.engines import engines
from scenarios.compare.outcome import Outcome
from scenarios.compare.pictures import draw_outcomes, playback
from scenarios.format.loading import dump
from scenarios.format.scenario import Scenario
from scenarios.report.provenance import commit, host, now, versions
from scenarios.run_folder import RunFolder


def compare(
    name: str,
    scenario: Scenario,
    folder: Path,
    *,
    time_out: float,
    replace: bool = False,
    only: Sequence[str] = (),
    begin: Callable[[str], None] = lambda _: None,
) -> tuple[list[Outcome], Path]:
    """Run it under every engine into `folder`: comparison.json, comparison.png, comparison.html.

    An engine that fails, crashes or takes longer than `time_out` [s] is an outcome with its error.
    `begin` is called with each engine's name. Ctrl-C ends all of it, and nothing is kept.
    """
    target = RunFolder(folder, replace=replace)
    partial = target.open()
    try:
        saved = partial / "scenario.yaml"
        saved.write_text(dump(name, scenario), encoding="utf-8")
        outcomes = []
        for engine in only or engines():
            begin(engine)
            outcomes.append(run_apart(engine, saved, time_out))
        _save(name, scenario, outcomes, partial / "comparison.json")
        draw_outcomes(name, scenario, outcomes, partial / "comparison.png")
        html = playback(scenario, outcomes)
        (partial / "comparison.html").write_text(html, encoding="utf-8")
        return outcomes, target.keep()
    finally:
        target.discard()


def _save(name: str, scenario: Scenario, outcomes: Sequence[Outcome], path: Path) -> None:
    rows = [
        {
            "engine": outcome.engine,
            "verdict": outcome.verdict,
            "error": outcome.error,
            "wall_time": outcome.wall_time,
            "real_time_factor": _number(outcome.real_time_factor),
            "creep [um/s]": _number(outcome.creep(scenario.acceptance.window)),
            "energy gained [J]": _number(outcome.energy_gained()),
            "deepest overlap [mm]": _number(1e3 * outcome.penetration),
            "figures": {key: _number(value) for key, value in outcome.figures.items()},
        }
        for outcome in outcomes
    ]
    contents = {
        "scenario": name, "truth": scenario.acceptance.truth, "cannot": scenario.cannot,
        "engines": rows, "date": now(), "commit": commit(), "host": host(),
        "versions": versions(),
    }  # fmt: skip
    path.write_text(json.dumps(contents, indent=2) + "\n", encoding="utf-8")


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
