"""Run one scenario or the whole library from the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.text import Text

from contact_toolkit import MeshError
from scenarios.format.errors import NotInstalledError, ScenarioError
from scenarios.format.loading import load
from scenarios.format.scenario import Scenario
from scenarios.judge.verdicts import ERROR, INTERRUPTED, SKIPPED
from scenarios.progress import run_with_progress
from scenarios.report.report import (
    between_marks,
    results_markdown,
    results_table,
    summary_tables,
)
from scenarios.report.summary import Summary
from scenarios.run_folder import RunFolder

PASSED, FAILED, MISTAKE, STOPPED = 0, 1, 2, 130  # exit statuses


class Batch:
    """Runs scenarios one after another; `folder` is that of the last run kept."""

    def __init__(
        self, console: Console, overrides: Sequence[str], *, replace: bool, live: bool
    ) -> None:
        self._console = console
        self._overrides = list(overrides)
        self._replace = replace
        self._live = live
        self.folder: Path | None = None

    def run_one(self, wanted: str, out: Path | None) -> int:
        """Run a scenario into `out`, or runs/NAME; return the exit status.

        Raises ScenarioError or MeshError if it cannot be run.
        """
        name, scenario = load(wanted, self._overrides)
        summary = self._run(wanted, name, scenario, out or Path("runs") / name)
        return PASSED if summary.acceptable else STOPPED if _stopped(summary) else FAILED

    def run_all(self, names: Sequence[str], out: Path, table: Path | None = None) -> int:
        """Run scenarios into folders of their names in `out`; Ctrl-C stops them all.

        Their results go to `out`/RESULTS.md, and between the marks of the document `table`.

        What is wrong with any of them, or with its folder, is reported before the first is run;
        one that needs a package which is not installed is skipped.
        """
        loaded = [load(name, self._overrides) for name in names]
        for name, _ in loaded:
            folder = RunFolder(out / name, replace=self._replace)
            folder.open()
            folder.discard()
        if table is not None:
            between_marks(table, "scenarios")
        if long := [name for name, scenario in loaded if scenario.long]:
            self._console.print(Text(f"among them, minutes each: {', '.join(long)}"))
        summaries = []
        for name, scenario in loaded:
            try:
                summaries.append(self._run(name, name, scenario, out / name))
            except NotInstalledError as error:
                self._console.print(Text(f"{name}: skipped: {error}"), soft_wrap=True)
                summaries.append(Summary(name, verdict=SKIPPED, error=str(error)))
            except (ScenarioError, MeshError) as error:
                self._complain(f"{error}")
                summaries.append(Summary(name, verdict=ERROR, error=str(error)))
            if _stopped(summaries[-1]):
                left = len(loaded) - len(summaries)
                self._console.print(f"stopped; {left} scenarios were not run")
                break
        self._console.print(results_table(summaries))
        written = out / "RESULTS.md"
        results = results_markdown(summaries, dict(loaded))
        written.write_text(results, encoding="utf-8")
        self._console.print(Text(f"table: {written}"), soft_wrap=True)
        if table is not None and not _stopped(summaries[-1]):
            before, _, after = between_marks(table, "scenarios")
            table.write_text(before + results + after, encoding="utf-8")
        if _stopped(summaries[-1]):
            return STOPPED
        return PASSED if all(summary.acceptable for summary in summaries) else FAILED

    def _run(self, wanted: str, name: str, scenario: Scenario, folder: Path) -> Summary:
        try:
            summary = run_with_progress(
                self._console,
                name,
                scenario,
                folder,
                replace=self._replace,
                overrides=self._overrides,
                live=self._live,
            )
        except KeyboardInterrupt:
            self._complain(f"{wanted}: interrupted during set-up; nothing was kept")
            return Summary(name, verdict=INTERRUPTED)
        except NotInstalledError:
            raise
        except (ScenarioError, MeshError) as error:
            said = str(error)
            raise ScenarioError(
                said if said.startswith(str(folder)) else f"{wanted}: {said}"
            ) from error
        except OSError:
            raise
        except Exception as error:  # noqa: BLE001  of the simulation: its contact state, or Drake
            self._complain(f"{wanted}: {error}; what was recorded until then is in {folder}")
            self.folder = folder
            return Summary(name, verdict=ERROR, error=str(error))
        self.folder = Path(summary.folder)
        self._console.print(*summary_tables(summary), sep="\n")
        for message in summary.warnings:
            line = Text.assemble(("warning:", "yellow"), f" {message}")
            self._console.print(line, soft_wrap=True)
        self._console.print(Text(f"playback: {self.folder / 'playback.html'}"), soft_wrap=True)
        if self.folder != folder:
            self._console.print(Text(f"{folder} was taken meanwhile by another run"))
        return summary

    def _complain(self, message: str) -> None:
        line = Text.assemble(("error:", "red"), f" {message}")
        Console(stderr=True).print(line, soft_wrap=True)


def _stopped(summary: Summary) -> bool:
    return summary.verdict == INTERRUPTED
