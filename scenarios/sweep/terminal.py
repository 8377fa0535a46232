"""A sweep from the terminal, behind a progress bar."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.text import Text

from scenarios.sweep.plan import Plan
from scenarios.sweep.study import load_study
from scenarios.sweep.sweep import Tally, sweep


def sweep_with_progress(
    console: Console,
    name_or_file: str,
    out: Path | None,
    *,
    resume: bool = False,
    runs: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Tally:
    """Run a study into a folder, runs/NAME unless given, and say what came of it."""
    name, study, base = load_study(name_or_file)
    if runs is not None:
        study = replace(study, runs=runs)
        study.check(name)
    folder = out or Path("runs") / name
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} runs"),
        TextColumn("{task.fields[said]}"),
        console=console,
    )
    with bar:
        task = bar.add_task(name, total=study.runs, said="")

        def report(tally: Tally) -> None:
            bar.update(task, completed=tally.done, total=tally.total, said=_told(tally))

        tally = sweep(
            Plan(name, study, base),
            folder,
            resume=resume,
            scheduler=scheduler,
            workers=workers,
            progress=report,
        )
    said = f"{tally.done} of {tally.total} runs, {tally.done - tally.before} of them now: "
    counts = (
        f"{tally.passed} passed, {tally.failed} failed, {tally.without_figures} without figures"
    )
    console.print(Text(said + counts), soft_wrap=True)
    if tally.stopped:
        console.print(Text("stopped; --resume goes on"))
    console.print(Text(f"rows: {folder / 'rows'}"), soft_wrap=True)
    return tally


def _told(tally: Tally) -> str:
    """Return success rate and time left in words."""
    now = tally.done - tally.before
    judged = tally.passed + tally.failed
    said = f"{100 * tally.passed / judged:.0f} % passed" if judged else ""
    if now:
        left = (time.monotonic() - tally.started) / now * (tally.total - tally.done)
        said += f", {left / 60:.0f} min left" if left > 90 else f", {left:.0f} s left"
    return said
