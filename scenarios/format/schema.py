"""The keys of a scenario file: as a table for people, as JSON schema for editors."""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
import types
import typing
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig
from rich.table import Table
from rich.text import Text

from scenarios.format.choices import choices_at
from scenarios.format.scenario import Scenario

_DRAKE = "Drake's own"
_DIRECTIVES = "https://drake.mit.edu/doxygen_cxx/group__multibody__parsing.html"


@dataclasses.dataclass(frozen=True)
class Key:
    """One key: its place, as `joints.*.kind`, its meaning, unit, default, allowed values."""

    place: str
    meaning: str
    unit: str
    default: str
    allowed: tuple[str, ...]


def keys() -> Iterator[Key]:
    """Yield every key of a scenario in the order of the file."""
    yield from _keys_of(Scenario, "")


def schema_table() -> Table:
    """Return the keys as a table."""
    table = Table("key", "unit", "default", "what it is, and what it may be", box=None)
    for key in keys():
        said = key.meaning + (f" One of: {', '.join(key.allowed)}." if key.allowed else "")
        table.add_row(Text(key.place, "bold"), Text(key.unit), Text(key.default), Text(said))
    return table


def json_schema() -> str:
    """Return the JSON schema of a scenario file: a mapping of names to scenarios."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Contact Toolkit scenarios",
        "type": "object",
        "additionalProperties": _schema_of(Scenario, ""),
    }
    return json.dumps(schema, indent=2)


def _fields(kind: type) -> Iterator[tuple[str, Any, Any, str]]:
    """Yield name, type, default and description of a dataclass's or Drake config's fields."""
    if not dataclasses.is_dataclass(kind):
        blank = kind()
        for field in kind.__fields__:  # type: ignore[attr-defined]
            yield field.name, field.type, getattr(blank, field.name), _DRAKE
        return
    said = _attributes(kind)
    blank = kind()
    hints = typing.get_type_hints(kind)
    for field in dataclasses.fields(kind):
        yield field.name, hints[field.name], getattr(blank, field.name), said.get(field.name, "")


def _keys_of(kind: type, prefix: str) -> Iterator[Key]:
    for name, hint, default, meaning in _fields(kind):
        place = f"{prefix}{name}"
        inner, suffix = _inner(hint)
        if _is_record(inner):
            if suffix:
                yield Key(place, meaning, "", _shown(default), ())
            yield from _keys_of(inner, f"{place}{suffix}.")
            continue
        unit = re.search(r"\[([^\]]+)\]", meaning)
        allowed = choices_at(place) or choices_at(f"{place}.*")
        yield Key(place, meaning, unit[1] if unit else "", _shown(default), allowed)


def _inner(hint: Any) -> tuple[Any, str]:
    """Return the type behind a list or mapping, and what stands for an element's name."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is dict:
        inner, suffix = _inner(arguments[1])
        return inner, f".*{suffix}"
    if origin is list:
        inner, suffix = _inner(arguments[0])
        return inner, f".*{suffix}"
    if origin in (typing.Union, types.UnionType):
        return next(a for a in arguments if a is not type(None)), ""
    return hint, ""


def _is_record(kind: Any) -> bool:
    return dataclasses.is_dataclass(kind) or kind in (SimulatorConfig, MultibodyPlantConfig)


def _attributes(kind: type) -> dict[str, str]:
    """Read the Attributes sections (numpydoc) of a class and those it derives from."""
    found: dict[str, str] = {}
    for base in reversed(inspect.getmro(kind)):
        names: list[str] = []
        _, _, section = (inspect.cleandoc(base.__doc__ or "")).partition("Attributes\n----------\n")
        for line in section.splitlines():
            if line and not line.startswith(" "):
                names = [name.strip() for name in line.split(",")]
                found |= dict.fromkeys(names, "")
            for name in names if line.startswith(" ") else ():
                found[name] = f"{found[name]} {line.strip()}".strip()
    return found


def _shown(default: Any) -> str:
    if default is None:
        return "unset"
    if isinstance(default, np.ndarray):
        default = default.tolist()
    if dataclasses.is_dataclass(default):
        return ""
    return "''" if default == "" else str(default)


_JSON_TYPES = {float: "number", int: "integer", bool: "boolean", str: "string"}


def _schema_of(hint: Any, place: str) -> dict[str, Any]:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if _is_record(hint):
        properties = {}
        for name, inner, _, meaning in _fields(hint):
            at = f"{place}.{name}" if place else name
            properties[name] = _schema_of(inner, at) | ({"description": meaning} if meaning else {})
        return {"type": "object", "additionalProperties": False, "properties": properties}
    if origin is dict:
        return {"type": "object", "additionalProperties": _schema_of(arguments[1], f"{place}.*")}
    if origin is list:
        return {"type": "array", "items": _schema_of(arguments[0], f"{place}.*")}
    if origin in (typing.Union, types.UnionType):
        return _schema_of(next(a for a in arguments if a is not type(None)), place)
    if hint is np.ndarray:
        return {"type": "array", "items": {"type": "number"}}
    if hint in _JSON_TYPES:
        allowed = choices_at(place)
        return {"type": _JSON_TYPES[hint]} | ({"enum": list(allowed)} if allowed else {})
    return {"type": "object", "description": f"Drake's model directive, see {_DIRECTIVES}"}
