"""Raw YAML into a dataclass; what cannot be converted is named by its place in the file."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast, get_args, get_origin, get_type_hints

from pydrake.common.yaml import yaml_dump, yaml_load, yaml_load_typed

from scenarios.format.errors import ScenarioError

Place: TypeAlias = tuple[str | int, ...]  # keys and list indices, from the outside in
Loaded = TypeVar("Loaded")


def read_mapping(path: Path, of: str = "scenarios") -> dict[str, Any]:
    """Return a YAML file's mapping of names to what they stand for; raise ScenarioError."""
    try:
        contents = yaml_load(filename=str(path))
    except Exception as error:  # the parser raises its own kinds
        raise ScenarioError(f"{path}: not readable as YAML: {error}") from error
    if not isinstance(contents, dict) or not contents:
        raise ScenarioError(f"{path}: expected a mapping of names to {of}")
    return contents


def typed(schema: type[Loaded], raw: dict[str, Any], where: str) -> Loaded:
    """Return the dataclass of a raw mapping; raise ScenarioError naming the entry in `where`."""
    try:
        return _parse(schema, raw)
    except Exception as error:  # the loader raises whatever a conversion raises
        raise ScenarioError(f"{where}: {_explain(error, schema, raw)}") from error


def _parse(schema: type[Loaded], raw: dict[str, Any], default: Loaded | None = None) -> Loaded:
    """Convert entry by entry: the loader is slow, and runs of a sweep differ in few entries.

    Mappings are sorted, as Drake dumps them: their order does not depend on where they were kept.
    """
    default = schema() if default is None else default
    kinds = _hints(cast(Any, schema))
    values: dict[str, Any] = {}
    for key, value in raw.items():
        if key.startswith("_"):  # private to the file, as Drake has it
            continue
        kind: Any = kinds.get(key)
        origin, of = get_origin(kind), get_args(kind)
        if origin is dict and isinstance(value, dict):
            values[key] = {}
            for name, entry in sorted(value.items()):
                if _is_plain(of[1], entry):
                    values[key][name] = _parse(of[1], entry)
                else:
                    values[key] |= _entry(schema, key, {name: entry})
        elif (numbers := _numbers(kind, value)) is not None:
            values[key] = numbers
        elif origin is list and isinstance(value, list):
            values[key] = [_entry(schema, key, [entry])[0] for entry in value]
        elif _is_plain(kind, value):
            values[key] = _parse(kind, value, getattr(default, key))
        else:
            values[key] = _entry(schema, key, value)
    return replace(default, **values)  # type: ignore[type-var]


@lru_cache(maxsize=64)
def _hints(schema: Any) -> dict[str, Any]:
    return get_type_hints(schema)


def _is_plain(kind: Any, value: Any) -> bool:
    """Whether it is a mapping for a dataclass of ours: its entries are converted one by one."""
    return is_dataclass(kind) and isinstance(value, dict) and "_tag" not in value


def _numbers(kind: Any, value: Any) -> Any:
    """Return numbers, or lists of such, as the loader would; None for what is left to it."""
    if kind in (float, float | None) and type(value) in (int, float):
        return float(value)
    if kind is int and type(value) is int:
        return value
    if get_origin(kind) is list and isinstance(value, list):
        (of,) = get_args(kind)
        entries = [_numbers(of, entry) for entry in value]
        return None if None in entries else entries
    return None


@dataclass(frozen=True)
class _Entry:
    """A key of a schema with a raw value; equal to others that say the same."""

    schema: type
    key: str
    said: str
    value: Any = field(compare=False)


def _entry(schema: type, key: str, value: Any) -> Any:
    return deepcopy(_converted(_Entry(schema, key, repr(value), value)))


@lru_cache(maxsize=256)
def _converted(entry: _Entry) -> Any:
    data = yaml_dump({entry.key: entry.value})
    return getattr(yaml_load_typed(schema=entry.schema, data=data), entry.key)


def _explain(error: Exception, schema: type, raw: dict[str, Any]) -> str:
    """Name the entry that the loader stumbled over; it tells unknown keys without their parents."""
    said = str(error)
    place, value = _culprit(schema, raw, said)
    where = ".".join(map(str, place))
    if not where:
        return said
    if value is None:
        return f"{where} is empty"
    if "unknown to the schema" in said:
        return f"unknown key {where}" if f"'{place[-1]}'" in said else f"{where}: {said}"
    reason = "" if isinstance(error, AssertionError) else f" ({said})"  # it only repeats the value
    return f"{where} cannot be {value!r}{reason}"


def _culprit(schema: type, raw: dict[str, Any], said: str) -> tuple[Place, Any]:
    """Return the innermost entry without which the loader does not complain as it `said`."""
    place: Place = ()
    node: Any = raw
    relief = None  # what it says instead; taking away a good entry may be a mistake of its own
    while isinstance(node, dict | list):
        for key in node if isinstance(node, dict) else range(len(node)):
            complaint = _complaint(schema, _without(raw, (*place, key)))
            if complaint != said and relief in (None, complaint):
                place, node, relief = (*place, key), node[key], complaint
                break
        else:
            break
    return place, node


def _complaint(schema: type, raw: dict[str, Any]) -> str:
    try:
        _parse(schema, raw)
    except Exception as error:  # noqa: BLE001  the loader raises whatever a conversion raises
        return str(error)
    return ""


def _without(raw: dict[str, Any], place: Place) -> dict[str, Any]:
    copy: dict[str, Any] = deepcopy(raw)
    node: Any = copy
    for key in place[:-1]:
        node = node[key]
    del node[place[-1]]
    return copy
