"""Write a surface as a Wavefront OBJ file, the one mesh format every Drake role reads."""

from __future__ import annotations

from pathlib import Path

from scenarios.parts.surface import Surface


def obj_text(surface: Surface) -> str:
    """Return the contents of an OBJ file, every coordinate to the last bit."""
    vertices, faces = surface
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join(lines) + "\n"


def write_obj(path: Path, surface: Surface) -> Path:
    """Write (vertices, faces) to `path`, every coordinate to the last bit; return the path."""
    path.write_text(obj_text(surface), encoding="ascii")
    return path
