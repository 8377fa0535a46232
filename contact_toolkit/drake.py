"""The Drake systems under a name that no folder of yours has: the same objects as in `systems`."""

from __future__ import annotations

from typing import Any

from contact_toolkit.companions import import_companion


def __getattr__(name: str) -> Any:
    return getattr(import_companion("systems"), name)


def __dir__() -> list[str]:
    return list(import_companion("systems").__all__)
