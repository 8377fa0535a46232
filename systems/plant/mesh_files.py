"""Mesh files for Drake, which reads only some kinds: write the others as .obj into a cache."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np

from contact_toolkit.shapes.mesh_files import read_mesh_file
from contact_toolkit.shapes.primitives import Triangles

# Drake takes these as they are, for collision and for the eye.
READ_BY_DRAKE = (".obj", ".gltf", ".vtk")
CONVERTED = (".stl", ".ply", ".off", ".glb")

# Drake stands the y-up glTF model on its feet: (x, y, z) -> (x, -z, y).
_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def read_for_drake(path: Path) -> Triangles:
    """Return vertices (nv, 3) and faces (nf, 3) as Drake would have them stand: glTF z-up.

    Raises MeshError naming the file, the place and the mend.
    """
    vertices, faces = read_mesh_file(path)
    if path.suffix.lower() in (".glb", ".gltf"):
        vertices = vertices @ _Z_UP_FROM_Y_UP.T
    return vertices, faces.astype(np.int32)


def obj_text(vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return the contents of an .obj file; every bit of every number survives."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join(lines) + "\n"


def converted(path: Path, cache: Path | None = None) -> Path:
    """Return an .obj file with the surface of `path`, written unless it is there already.

    It lies in `cache`, by default `$XDG_CACHE_HOME/contact-toolkit/meshes` (`~/.cache/...`), under
    the file's name and the hash of its contents.
    """
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:20] if path.is_file() else ""
    folder = (cache or default_cache()) / "meshes"
    target = folder / f"{path.stem}-{path.suffix[1:].lower()}-{digest}.obj"
    if digest and target.is_file():
        return target
    text = obj_text(*read_for_drake(path))
    folder.mkdir(parents=True, exist_ok=True)
    partial = target.with_suffix(f".{os.getpid()}.tmp")
    partial.write_text(text)
    partial.replace(target)
    return target


def default_cache() -> Path:
    """Return `$XDG_CACHE_HOME/contact-toolkit`."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "contact-toolkit"
