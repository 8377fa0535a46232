"""The packages beside this one, `systems` and `scenarios`, or why they are hidden."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType


def import_companion(module: str) -> ModuleType:
    """Import `systems` or `scenarios`, or a module of theirs.

    Raises ImportError, naming both places, where a module or folder of that name comes first.
    """
    package = module.partition(".")[0]
    ours = Path(__file__).resolve().parents[1] / package
    spec = find_spec(package)
    found = Path(spec.origin).resolve() if spec is not None and spec.origin else None
    if found != ours / "__init__.py":
        where = "not found" if found is None else f"shadowed by {found}"
        raise ImportError(
            f"the package `{package}` of Contact Toolkit, {ours}, is {where}: "
            f"rename what is in the way, or start Python elsewhere"
        )
    return import_module(module)
