"""Approximate convex decomposition of meshes by CoACD.

Wei, Liu, Ling, Su, "Approximate convex decomposition for 3D meshes with collision-aware concavity
and tree search", ACM TOG 41(4), 2022. It takes seconds to minutes, so results are cached; and CoACD
ends the whole process on input it dislikes, so it runs in a process of its own.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import warnings
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

from contact_toolkit.shapes import decomposition_worker
from contact_toolkit.shapes.convex_pieces import ConvexPieces
from contact_toolkit.shapes.mesh import CollisionMesh, MeshError

_CACHE_FORMAT = 1  # part of the key: raise it when what is stored changes


class DecompositionError(RuntimeError):
    """CoACD ran out of time, crashed, or found no piece."""


def decompose(
    mesh: CollisionMesh,
    threshold: float = 0.05,
    *,
    max_pieces: int | None = None,
    seed: int = 0,
    timeout: float = 600.0,
    cache: bool = True,
) -> ConvexPieces:
    """Cover a solid with convex pieces, in the mesh's own frame.

    Queries on the pieces are far cheaper than on the mesh and off by about the threshold: hulls
    fill hollows in. The same input gives the same pieces.

    Parameters
    ----------
    mesh
        A closed mesh, wound outwards.
    threshold
        [-] How concave a piece may remain, as a fraction of the mesh's size: from 0.01 (many
        pieces) to 1 (the convex hull).
    max_pieces
        Merge down to this many at most, whatever the threshold.
    seed
        Of the search.
    timeout
        [s] After this the search is given up.
    cache
        Keep the result in `$XDG_CACHE_HOME/contact-toolkit` (`~/.cache/contact-toolkit` by default)
        under a hash of the mesh, the parameters and CoACD's version, and look there first.

    Raises
    ------
    MeshError
        If the mesh is open or inside out.
    DecompositionError
        If CoACD ran out of time or crashed.

    Examples
    --------
    >>> from contact_toolkit import CollisionMesh, decompose
    >>> from contact_toolkit.shapes.primitives import box
    >>> len(decompose(CollisionMesh(*box([0.1, 0.1, 0.1])), cache=False).pieces)  # convex already
    1
    """
    parameters = _parameters(threshold, max_pieces, seed)
    if not timeout > 0:
        raise ValueError(f"timeout must be a positive number of seconds, not {timeout}")
    _require_solid(mesh)
    stored = _cache_folder() / f"{_key(mesh, parameters)}.npz"
    if cache and (pieces := _load(stored)) is not None:
        return pieces
    with tempfile.TemporaryDirectory(prefix="contact-toolkit-") as folder:
        result = _run(mesh, parameters, timeout, Path(folder))
        pieces = _load(result)
        if pieces is None:
            raise DecompositionError("CoACD found no piece; is the mesh all but flat?")
        if cache:
            _store(result, stored)
    return pieces


def _parameters(threshold: float, max_pieces: int | None, seed: int) -> dict[str, float | int]:
    if not 0.01 <= threshold <= 1:
        raise ValueError(f"threshold must lie between 0.01 and 1, not {threshold}")
    if max_pieces is not None and max_pieces < 1:
        raise ValueError(f"max_pieces must be at least 1, not {max_pieces}")
    if not 0 <= seed < 2**32:
        raise ValueError(f"seed must lie between 0 and 2³² - 1, not {seed}")
    return {
        "threshold": float(threshold),
        "max_convex_hull": -1 if max_pieces is None else max_pieces,
        "seed": seed,
    }


def _require_solid(mesh: CollisionMesh) -> None:
    if not mesh.defects.closed:
        raise MeshError(
            f"decompose needs a closed mesh, and this one has {mesh.defects}; fill the holes and "
            f"unify the winding (for example trimesh.repair)"
        )
    if not mesh.volume > 0:
        raise MeshError(
            f"decompose needs a solid, and this mesh encloses {mesh.volume:g} m³: it is flat, or "
            f"inside out (reverse the order of the vertices in its facets)"
        )


def _run(
    mesh: CollisionMesh, parameters: dict[str, float | int], timeout: float, folder: Path
) -> Path:
    """Decompose in a child process; return the file with the pieces."""
    source, result = folder / "mesh.npz", folder / "pieces.npz"
    np.savez(source, vertices=mesh.vertices, faces=mesh.faces)
    worker = decomposition_worker.__file__
    # -P: the package's own folder must not shadow other packages' modules.
    command = [sys.executable, "-P", worker, str(source), str(result), json.dumps(parameters)]
    try:
        ended = subprocess.run(  # noqa: S603  nothing in the command comes from outside
            command, capture_output=True, text=True, errors="replace", timeout=timeout, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise DecompositionError(
            f"CoACD did not end within {timeout:g} s on {len(mesh.faces)} facets; raise the "
            f"timeout or the threshold, or simplify the mesh"
        ) from error
    if ended.returncode != 0 or not result.is_file():
        raise DecompositionError(f"CoACD {_how_it_ended(ended.returncode)}: {_last_line(ended)}")
    return result


def _how_it_ended(code: int) -> str:
    return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"failed with code {code}"


def _last_line(ended: subprocess.CompletedProcess[str]) -> str:
    lines = (ended.stdout + ended.stderr).split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")


def _cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "contact-toolkit" / "decompositions"


def _key(mesh: CollisionMesh, parameters: dict[str, float | int]) -> str:
    about = {"format": _CACHE_FORMAT, "coacd": version("coacd"), **parameters}
    digest = hashlib.sha256(json.dumps(about, sort_keys=True).encode())
    for table in (mesh.vertices, mesh.faces):
        digest.update(np.int64(len(table)).tobytes())
        digest.update(np.ascontiguousarray(table).tobytes())
    return digest.hexdigest()


def _load(path: Path) -> ConvexPieces | None:
    """Read pieces; None where there are none to read."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            points, first = arrays["points"], arrays["first"]
        return ConvexPieces(np.split(points, first[1:-1]))
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):
        return None


def _store(result: Path, stored: Path) -> None:
    try:
        stored.parent.mkdir(parents=True, exist_ok=True)
        # Beside it first: a reader never sees half a file.
        with tempfile.NamedTemporaryFile(dir=stored.parent, delete=False) as beside:
            beside.write(result.read_bytes())
        Path(beside.name).replace(stored)
    except OSError as error:
        warnings.warn(f"the decomposition could not be cached: {error}", stacklevel=3)
