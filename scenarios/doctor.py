"""Check that the installation works, piece by piece."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable

import numpy as np
from rich.table import Table

from scenarios.report.provenance import versions


def examine() -> tuple[Table, bool]:
    """Return a table of findings, and whether all that is needed works."""
    table = Table(box=None, pad_edge=False, show_header=False)
    healthy = True
    for name, (needed, probe) in _PROBES.items():
        try:
            finding, mark = probe(), "[green]✓[/]"
        except Exception as error:  # noqa: BLE001  a doctor reports whatever is wrong
            finding, mark = f"{type(error).__name__}: {error}", "[red]✗[/]" if needed else "–"
            healthy &= not needed
        table.add_row(f"{mark} {name}", finding)
    return table, healthy


def _python() -> str:
    return f"{sys.version.split()[0]}, {sys.executable}"


def _package() -> str:
    return versions()["contact-toolkit"]


def _engine() -> str:
    from contact_toolkit import CollisionMesh, distance
    from scenarios.parts import box

    cube, pose = CollisionMesh(*box()), np.eye(4)
    pose[0, 3] = 0.25
    found = distance(cube, cube, pose).distance
    if abs(found - 0.15) > 1e-12:
        raise ArithmeticError(f"two cubes 0.15 m apart come out {found} m apart")
    return "two cubes 0.15 m apart are 0.15 m apart"


def _drake() -> str:
    from pydrake.multibody.plant import MultibodyPlant

    MultibodyPlant(0.0).Finalize()
    return versions()["drake"]


def _library() -> str:
    from scenarios.format.loading import library, load

    return f"{len([load(name) for name in library()])} scenarios in the library"


def _browser() -> str:
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if path := shutil.which(name):
            return path
    raise FileNotFoundError("no Chromium; only the browser tests need it")


def _cores() -> str:
    return f"{len(os.sched_getaffinity(0))} usable"


_PROBES: dict[str, tuple[bool, Callable[[], str]]] = {
    "Python": (True, _python),
    "contact-toolkit": (True, _package),
    "engine": (True, _engine),
    "Drake": (True, _drake),
    "scenarios": (True, _library),
    "cores": (False, _cores),
    "Chromium": (False, _browser),
}
