"""SCENES.md, and the README's table of scenes."""

from __future__ import annotations

import math
from collections.abc import Mapping

from benchmarks.discrete_steps import ENGINES
from benchmarks.scenes.run import SCENES, Result
from benchmarks.scenes.scene import TIME_STEP, Scene

Results = Mapping[str, Mapping[str, Result]]  # scene → engine → result

HEADING = f"""# Scenes of strangers' models

Made by `python -m benchmarks.scenes`. Model files of installable packages (`pip install
'contact-toolkit[models]'`) in discrete plants with steps of {1e3 * TIME_STEP:g} ms; nothing is set
but what a file lacks. Each figure has a truth that is not ours: statics, a closed form, or Drake's
mass matrix. Every contact takes the same plant, in a process of its own; all geometry is compliant
by Drake's default properties unless tagged. × real time: simulated time over time of one core,
without building. Bold: not the truth. Drake takes a mesh as its convex hull, so that the nut is on
no thread there; of hulls is asked, too, how deep bodies are in each other.

"""


def document(results: Results) -> str:
    """Return SCENES.md."""
    lines = [HEADING + _row("scene", "figure", "truth", *ENGINES), _row(*["---"] * 6)]
    for name, by_engine in results.items():
        lines += _rows_of(SCENES[name], by_engine)
    lines.append("\n## What they are made of\n")
    lines += [f"- {name}: {SCENES[name].made_of}" for name in results]
    lines.append("\n## What they are warned of\n\nUnder our contact, word by word.\n")
    for name, by_engine in results.items():
        lines += [f"- {name}: {text}" for text in by_engine["ours"].said]
    return "\n".join(lines) + "\n"


def short_table(results: Results) -> str:
    """Return the README's table: a row a scene, what is astray and how fast it ran."""
    lines = [_row("scene", "truth", *ENGINES), _row(*["---"] * 5)]
    for name, by_engine in results.items():
        scene = SCENES[name]
        truth = ", ".join(f"{figure} {truth}" for figure, truth in scene.truths.items())
        cells = (_verdict(scene, by_engine[engine]) for engine in ENGINES)
        lines.append(_row(name, truth, *cells))
    return "\n".join(lines) + "\n"


def _rows_of(scene: Scene, by_engine: Mapping[str, Result]) -> list[str]:
    results = [by_engine[engine] for engine in ENGINES]
    rows = [
        _row(
            scene.name if i == 0 else "",
            figure,
            str(truth),
            *(_cell(figure, each, astray=figure in each.astray(scene)) for each in results),
        )
        for i, (figure, truth) in enumerate(scene.truths.items())
    ]
    rows.append(_row("", "× real time", "", *(_figure(each.real_time_factor) for each in results)))
    rows.append(_row("", "memory [MB]", "", *(_figure(each.megabytes) for each in results)))
    return rows


def _cell(figure: str, result: Result, *, astray: bool) -> str:
    if result.failure:
        return result.failure
    text = _figure(result.figures[figure])
    return f"**{text}**" if astray else text


def _verdict(scene: Scene, result: Result) -> str:
    if result.failure:
        return result.failure
    astray = (f"{name} {_figure(value)}" for name, value in result.astray(scene).items())
    return f"{', '.join(astray) or 'as the truth'}; × {result.real_time_factor:.2g}"


def _figure(value: float) -> str:
    if math.isnan(value):
        return "–"
    if abs(value) >= 1e4 or 0 < abs(value) < 1e-3:
        return f"{value:.1e}"
    return f"{value:.4g}"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cells) + " |"
