"""Generators of parts, under a name that no folder of yours has: as in `scenarios.parts`."""

from __future__ import annotations

from typing import Any

from contact_toolkit.companions import import_companion


def __getattr__(name: str) -> Any:
    return getattr(import_companion("scenarios.parts"), name)


def __dir__() -> list[str]:
    return list(import_companion("scenarios.parts").__all__)
