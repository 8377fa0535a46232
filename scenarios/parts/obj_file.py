"""Write a surface as a Wavefront OBJ file, the one mesh format every Drake role reads."""

from __future__ import annotations

from pathlib import Path

from scenarios.parts.surface import Surface


def write_obj(path: Path, surface: Surface) -> Path:
    """Write (vertices, faces) to `path`, every coordinate to the last bit; return the path."""
    vertices, faces = surface
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path
