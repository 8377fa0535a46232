"""The command line, `contact-toolkit`."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from contact_toolkit import MeshError
from scenarios.format.errors import ScenarioError

app = typer.Typer(
    name="contact-toolkit",
    help="Real contact for Drake: run scenarios, look at their results, query meshes.",
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
    add_completion=False,
    rich_markup_mode=None,  # in markup, units in brackets would be taken for styles
)
console = Console()

STOPPED = 130  # exit status after Ctrl-C, as shells have it

Name = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="a scenario of the library, or a YAML file")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override, as contact.alpha=3; repeatable"),
]
RunFolder = Annotated[Path, typer.Argument(metavar="DIR", help="a run folder")]
MeshOrPart = Annotated[str, typer.Argument(help="a mesh file, or a part such as doughnut")]
Scale = Annotated[
    float, typer.Option(help="factor from the mesh files' unit to metres: 0.001 for millimetres")
]


def _show_version(wanted: bool) -> None:
    if wanted:
        from scenarios.report.provenance import package_version

        found = {name: package_version(name) for name in ("contact-toolkit", "drake")}
        console.print(Text(", ".join(f"{name} {number}" for name, number in found.items())))
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="print the version and exit", callback=_show_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Real contact for Drake: run scenarios, look at their results, query meshes."""


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


def _warn(messages: list[str]) -> None:
    """Print warnings of a run at its end, without the lines of code that gave them."""
    for message in messages:
        console.print(Text.assemble(("warning:", "yellow"), f" {message}"), soft_wrap=True)


def _complain(message: str) -> None:
    # As Text: in markup, units in brackets would be taken for styles.
    line = Text.assemble(("error:", "red"), f" {message}")
    Console(stderr=True).print(line, soft_wrap=True)


def _tell(what: str, path: Path) -> None:
    console.print(Text(f"{what}: {path}"), soft_wrap=True)


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios that come with the project."""
    from scenarios.format.loading import library, load
    from scenarios.report.report import scenario_table

    console.print(scenario_table({name: load(name)[1] for name in library()}))


@app.command()
def run(
    name_or_file: Annotated[
        str | None, typer.Argument(metavar="[NAME_OR_FILE]", help="a scenario, or a YAML file")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="run folder; runs/NAME unless given")] = None,
    force: Annotated[bool, typer.Option("--force", help="replace an earlier run")] = False,
    meshcat: Annotated[bool, typer.Option("--meshcat", help="watch live in the browser")] = False,
    video: Annotated[
        Path | None, typer.Option(help="also make a video of the playback, .mp4 or .gif")
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="run the whole library")] = False,
    table: Annotated[
        Path | None,
        typer.Option(help="with --all: a document to write the results into, between its marks"),
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Run a scenario into a folder and judge it; exit with 1 if it fails its acceptance."""
    from scenarios.batch import Batch
    from scenarios.format.loading import library
    from scenarios.report.video import check_video, make_video

    if everything == (name_or_file is not None):
        raise typer.BadParameter("give either a scenario or --all")
    if table is not None and not everything:
        raise typer.BadParameter("--table goes with --all")
    if video is not None and everything:
        raise typer.BadParameter("--video goes with one scenario")
    batch = Batch(console, overrides or [], replace=force, live=meshcat)
    with _mistakes_without_traceback():
        if video is not None:
            check_video(video)
        if everything:
            status = batch.run_all(list(library()), out or Path("runs"), table)
        else:
            status = batch.run_one(str(name_or_file), out)
        if video is not None and batch.folder is not None:
            _tell("video", make_video(batch.folder, video))
    raise typer.Exit(status)


@app.command()
def compare(
    name_or_file: Name,
    out: Annotated[
        Path | None, typer.Option(help="folder; runs/NAME-compared unless given")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="replace an earlier comparison")] = False,
    table: Annotated[
        Path | None,
        typer.Option(help="a document to write the results into, between the marks of the name"),
    ] = None,
    engine: Annotated[
        list[str] | None, typer.Option(help="only this engine, as 'ours, implicit'; repeatable")
    ] = None,
    time_out: Annotated[float, typer.Option(min=1.0, help="time an engine may take [s]")] = 600.0,
    overrides: Overrides = None,
) -> None:
    """Run a scenario under ours, Drake's and (if installed) MuJoCo's contact, side by side."""
    from scenarios.compare.compare import compare as compare_engines
    from scenarios.compare.document import check_document, write_into
    from scenarios.compare.engines import absent_engines, engines
    from scenarios.compare.tables import comparison_table
    from scenarios.format.loading import load

    with _mistakes_without_traceback():
        name, scenario = load(name_or_file, overrides or ())
        if table is not None:
            check_document(table, name)
        for wanted in engine or ():
            if wanted not in engines():
                there = "; ".join([*engines(), *absent_engines()])
                raise ScenarioError(f"no engine is called '{wanted}' here; there are: {there}")
        folder = out or Path("runs") / f"{name}-compared"
        running = ""

        def begin(engine: str) -> None:
            nonlocal running
            running = f"while {engine} was running"
            status.update(f"{name}: {engine}")

        try:
            with console.status(name) as status, _mistakes_in(name_or_file):
                outcomes, kept = compare_engines(
                    name,
                    scenario,
                    folder,
                    replace=force,
                    only=engine or (),
                    time_out=time_out,
                    begin=begin,
                )
        except KeyboardInterrupt:
            _complain(f"{name}: interrupted {running or 'during set-up'}; nothing was kept")
            raise typer.Exit(130) from None
        console.print(comparison_table(name, scenario, outcomes))
        if table is not None:
            write_into(table, name, scenario, outcomes, kept)
        for missing, why in scenario.cannot.items():
            console.print(Text(f"{missing}: {why}"), soft_wrap=True)
        for told in absent_engines():
            console.print(Text(told), soft_wrap=True)
        _tell("comparison", kept / "comparison.html")


@app.command()
def play(name_or_file: Name, overrides: Overrides = None) -> None:
    """Simulate a scenario live in the browser, at real time if the machine can; keep nothing."""
    from scenarios.format.loading import load
    from scenarios.live import play_live

    with _mistakes_without_traceback():
        name, scenario = load(name_or_file, overrides or ())
        with _mistakes_in(name_or_file):
            _warn(play_live(console, name, scenario))


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
def gallery(
    runs: Annotated[Path, typer.Argument(metavar="DIR", help="a folder of runs")] = Path("runs"),
    out: Annotated[Path, typer.Option(help="where the pictures go")] = Path("gallery"),
) -> None:
    """Draw the key frame of every run in a folder, and a sheet of them all, as PNG."""
    from scenarios.report.gallery import make_gallery

    with _mistakes_without_traceback():
        for path in make_gallery(runs, out):
            _tell("picture", path)


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="the folder of a run or a sweep")],
    playback: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RUN",
            help="of a sweep: simulate best, worst, failed or the run of this number again",
        ),
    ] = None,
) -> None:
    """Of a run: print its tables and draw its time series. Of a sweep: write its page."""
    from scenarios.report.report import redraw, summary_tables
    from scenarios.report.summary import Summary
    from scenarios.sweep.dataset import is_sweep
    from scenarios.sweep.report import simulate_again, write_report

    with _mistakes_without_traceback():
        if is_sweep(folder):
            for wanted in playback or ():
                made = simulate_again(folder, wanted)
                _tell(f"{wanted}, {made.verdict}", Path(made.folder) / "playback.html")
            _tell("report", write_report(folder))
            return
        if playback:
            raise typer.BadParameter("--playback goes with the folder of a sweep")
        summary = Summary.load(folder)
        console.print(*summary_tables(summary), sep="\n")
        _warn(summary.warnings)
        for path in redraw(folder):
            _tell("figure", path)


@app.command()
def sweep(
    study: Annotated[str, typer.Argument(metavar="FILE", help="a study of ours, or a YAML file")],
    out: Annotated[Path | None, typer.Option(help="folder; runs/NAME unless given")] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="go on with the sweep that is in the folder")
    ] = False,
    runs: Annotated[int | None, typer.Option(help="how many, in place of the study's")] = None,
    workers: Annotated[
        int | None, typer.Option(help="processes on this machine; one a core unless given")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of a Dask cluster, as tcp://host:8786")
    ] = None,
) -> None:
    """Run a scenario many times with varied values; one row a run, in a Parquet dataset."""
    from scenarios.sweep.terminal import sweep_with_progress

    with _mistakes_without_traceback():
        done = sweep_with_progress(
            console, study, out, resume=resume, runs=runs, workers=workers, scheduler=scheduler
        )
    raise typer.Exit(STOPPED if done.stopped else 0)


@app.command()
def fit(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="what to fit to which series")],
    out: Annotated[
        Path | None, typer.Option(help="also write fit.json and fit.png into this folder")
    ] = None,
) -> None:
    """Find parameters from measured series; exit with 1 if one of them is not determined."""
    from scenarios.sweep.fit_report import fit_with_progress

    with _mistakes_without_traceback():
        found, written = fit_with_progress(console, file, out)
        for path in written:
            _tell("written", path)
    raise typer.Exit(0 if found.converged and not found.undetermined else 1)


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
    scale: Scale = 1.0,
) -> None:
    """Print the closest points of two meshes, and how deep they are in each other."""
    from scenarios.report.inspection import distance_table

    with _mistakes_without_traceback():
        console.print(distance_table(a, b, at, rpy, standoff, scale=scale))


@app.command()
def inspect(
    mesh: MeshOrPart,
    picture: Annotated[Path | None, typer.Option(help="also draw it into this PNG file")] = None,
    scale: Scale = 1.0,
) -> None:
    """Print a mesh's size, defects and hierarchy."""
    from scenarios.report.inspection import draw_mesh, inspection_table, open_mesh

    with _mistakes_without_traceback():
        opened = open_mesh(mesh, scale)
        console.print(inspection_table(mesh, opened))
        if picture is not None:
            _tell("picture", draw_mesh(opened, picture))


@app.command()
def schema(
    json: Annotated[
        bool, typer.Option("--json", help="as a JSON schema, for editors to check YAML with")
    ] = False,
) -> None:
    """Print every key of a scenario file with its meaning, unit, default and allowed values."""
    from scenarios.format.schema import json_schema, schema_table

    if json:
        typer.echo(json_schema())
    else:
        console.print(schema_table())


@app.command()
def parts(
    name: Annotated[str | None, typer.Argument(help="a part, for its parameters")] = None,
) -> None:
    """List the parts that scenarios can generate, or the parameters of one."""
    from scenarios.report.inspection import part_table, parts_table

    with _mistakes_without_traceback():
        console.print(part_table(name) if name else parts_table())


@app.command()
def doctor() -> None:
    """Check the installation; exit with 1 if something needed is broken."""
    from scenarios.doctor import examine

    table, healthy = examine()
    console.print(table)
    raise typer.Exit(0 if healthy else 1)
