"""The command line, `contact-toolkit`."""

from __future__ import annotations

import tempfile
import warnings
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from contact_toolkit import MeshError
from scenarios.errors import ScenarioError

app = typer.Typer(
    name="contact-toolkit",
    help="Real contact for Drake: run scenarios, look at their results, query meshes.",
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
    add_completion=False,
)
console = Console()

Name = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="a scenario of the library, or a YAML file")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override, as contact.alpha=3; repeatable"),
]
RunFolder = Annotated[Path, typer.Argument(metavar="DIR", help="a run folder")]
MeshOrPart = Annotated[str, typer.Argument(help="a mesh file, or a part such as doughnut")]


@contextmanager
def _mistakes_without_traceback() -> Iterator[None]:
    try:
        yield
    except (ScenarioError, MeshError) as error:
        _complain(str(error))
        raise typer.Exit(2) from error
    except OSError as error:
        if error.filename is None:
            raise
        _complain(f"{error.filename}: {error.strerror}; choose another path")
        raise typer.Exit(2) from error


@contextmanager
def _mistakes_in(wanted: str) -> Iterator[None]:
    """Say which scenario holds a mistake that shows only when its diagram is built."""
    try:
        yield
    except (ScenarioError, MeshError) as error:
        raise ScenarioError(f"{wanted}: {error}") from error


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Print warnings at the end, without the lines of code that gave them."""
    with warnings.catch_warnings(record=True) as told:
        try:
            yield
        finally:
            for warning in told:
                line = Text.assemble(("warning:", "yellow"), f" {warning.message}")
                console.print(line, soft_wrap=True)


def _complain(message: str) -> None:
    # As Text: in markup, units in brackets would be taken for styles.
    line = Text.assemble(("error:", "red"), f" {message}")
    Console(stderr=True).print(line, soft_wrap=True)


def _tell(what: str, path: Path) -> None:
    console.print(Text(f"{what}: {path}"), soft_wrap=True)


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios that come with the project."""
    from scenarios.loading import library, load
    from scenarios.report import scenario_table

    console.print(scenario_table({name: load(name)[1] for name in library()}))


@app.command()
def run(
    name_or_file: Annotated[
        str | None, typer.Argument(metavar="[NAME_OR_FILE]", help="a scenario, or a YAML file")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="run folder; runs/NAME unless given")] = None,
    meshcat: Annotated[bool, typer.Option("--meshcat", help="watch live in the browser")] = False,
    everything: Annotated[bool, typer.Option("--all", help="run the whole library")] = False,
    overrides: Overrides = None,
) -> None:
    """Run a scenario into a folder and judge it; exit with 1 if it fails its acceptance."""
    from scenarios.loading import library, load
    from scenarios.progress import run_with_progress
    from scenarios.report import summary_tables

    if everything == (name_or_file is not None):
        raise typer.BadParameter("give either a scenario or --all")
    passed = True
    with _mistakes_without_traceback():
        for wanted in library() if everything else [str(name_or_file)]:
            name, scenario = load(wanted, overrides or ())
            folder = (out / name if everything else out) if out else Path("runs") / name
            try:
                with _mistakes_in(wanted), _warnings_in_one_line():
                    summary = run_with_progress(console, name, scenario, folder, live=meshcat)
            except RuntimeError as error:  # of the simulation: its step table, or Drake
                _complain(f"{wanted}: {error}; what was recorded until then is in {folder}")
                passed = False
                continue
            console.print(*summary_tables(summary), sep="\n")
            _tell("playback", folder / "playback.html")
            passed &= summary.acceptable
    raise typer.Exit(0 if passed else 1)


@app.command()
def play(name_or_file: Name, overrides: Overrides = None) -> None:
    """Simulate a scenario live in the browser, at real time if the machine can; keep nothing."""
    from scenarios.loading import load
    from scenarios.progress import play_live

    with _mistakes_without_traceback(), tempfile.TemporaryDirectory() as folder:
        name, scenario = load(name_or_file, overrides or ())
        with _mistakes_in(name_or_file), _warnings_in_one_line():
            play_live(console, name, scenario, Path(folder))


@app.command()
def replay(folder: RunFolder) -> None:
    """Open the playback of a run in the browser."""
    with _mistakes_without_traceback():
        playback = folder.resolve() / "playback.html"
        if not playback.is_file():
            raise ScenarioError(f"{folder}: not a run folder, it has no playback.html")
        _tell("playback", playback)
        webbrowser.open(playback.as_uri())


@app.command()
def report(folder: RunFolder) -> None:
    """Print the tables of a run and draw its time series afresh."""
    from scenarios.report import redraw, summary_tables
    from scenarios.summary import Summary

    with _mistakes_without_traceback():
        console.print(*summary_tables(Summary.load(folder)), sep="\n")
        for path in redraw(folder):
            _tell("figure", path)


@app.command()
def distance(
    a: MeshOrPart,
    b: MeshOrPart,
    at: Annotated[
        tuple[float, float, float], typer.Option(metavar="X Y Z", help="position of B in A [m]")
    ] = (0.0, 0.0, 0.0),
    rpy: Annotated[
        tuple[float, float, float], typer.Option(metavar="R P Y", help="rotation of B in A [deg]")
    ] = (0.0, 0.0, 0.0),
    standoff: Annotated[
        float | None, typer.Option(help="also count witness pairs closer than this [m]")
    ] = None,
) -> None:
    """Print the closest points of two meshes."""
    from scenarios.inspection import distance_table

    with _mistakes_without_traceback():
        console.print(distance_table(a, b, at, rpy, standoff))


@app.command()
def inspect(
    mesh: MeshOrPart,
    picture: Annotated[Path | None, typer.Option(help="also draw it into this PNG file")] = None,
) -> None:
    """Print a mesh's size, defects and hierarchy."""
    from scenarios.inspection import draw_mesh, inspection_table, open_mesh

    with _mistakes_without_traceback():
        opened = open_mesh(mesh)
        console.print(inspection_table(mesh, opened))
        if picture is not None:
            _tell("picture", draw_mesh(opened, picture))


@app.command()
def doctor() -> None:
    """Check the installation; exit with 1 if something needed is broken."""
    from scenarios.doctor import examine

    table, healthy = examine()
    console.print(table)
    raise typer.Exit(0 if healthy else 1)
