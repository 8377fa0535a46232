"""Paths in a scenario file: relative to that file, not to where the user happens to stand."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse


def resolve_paths(raw: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the raw scenario with the paths of models, meshes and packages made absolute.

    What has a scheme (`package://`, `file://`) is left as it is; so is whatever is not of the
    expected kind, which the typed loader then tells.
    """
    resolved = deepcopy(raw)
    directives = resolved.get("directives")
    for directive in directives if isinstance(directives, list) else []:
        for kind in ("add_model", "add_directives"):
            what = directive.get(kind) if isinstance(directive, dict) else None
            if isinstance(what, dict) and _is_path(what.get("file")):
                what["file"] = (folder / what["file"]).resolve().as_uri()
    for place, key in (("parts", "mesh"), ("packages", None)):
        entries = resolved.get(place)
        if not isinstance(entries, dict):
            continue
        for name, entry in entries.items():
            if key is None and _is_path(entry):
                entries[name] = str((folder / entry).resolve())
            elif key and isinstance(entry, dict) and _is_path(entry.get(key)):
                entry[key] = str((folder / entry[key]).resolve())
    return resolved


def named_files(resolved: dict[str, Any]) -> Iterator[Path]:
    """Yield the model and mesh files that a scenario with resolved paths names."""
    for directive in resolved.get("directives") or []:
        for what in directive.values() if isinstance(directive, dict) else ():
            file = what.get("file", "") if isinstance(what, dict) else ""
            if str(file).startswith("file://"):
                yield Path(unquote(urlparse(file).path))
    for part in (resolved.get("parts") or {}).values():
        if isinstance(part, dict) and part.get("mesh"):
            yield Path(part["mesh"])


def _is_path(value: Any) -> bool:
    return isinstance(value, str) and bool(value) and "://" not in value
