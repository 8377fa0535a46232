"""Find scenarios by name or file and load them, with overrides and errors that say where."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeAlias

from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load, yaml_load_typed

from scenarios.errors import ScenarioError
from scenarios.scenario import Scenario

LIBRARY = Path(__file__).parent / "library"

Place: TypeAlias = tuple[str | int, ...]  # keys and list indices, from the outside in


def library() -> dict[str, Path]:
    """Return the names of the scenarios that come with the project, and their files."""
    return {name: path for path in sorted(LIBRARY.glob("*.yaml")) for name in _read(path)}


def load(name_or_file: str, overrides: Sequence[str] = ()) -> tuple[str, Scenario]:
    """Return the name and contents of a scenario of the library or of a YAML file.

    A file maps names to scenarios; where it holds several, say which: `FILE:NAME`. Overrides are
    `path.to.key=value`, the value in YAML. Raises ScenarioError naming the file and the key.
    """
    path, name = _find(name_or_file)
    where = f"{path}: {name}"
    raw = _read(path)[name]
    if not isinstance(raw, dict):
        raise ScenarioError(f"{where}: expected the keys of a scenario, found {raw!r}")
    for override in overrides:
        _set(raw, override)
    try:
        scenario = _parse(raw)
    except Exception as error:  # the loader raises whatever a conversion raises
        raise ScenarioError(f"{where}: {_explain(error, raw)}") from error
    try:
        scenario.check()
    except ScenarioError as error:
        raise ScenarioError(f"{where}: {error}") from error
    return name, scenario


def dump(name: str, scenario: Scenario) -> str:
    """Return the YAML that `load` turns into the same scenario."""
    text = yaml_dump_typed(scenario, schema=Scenario, defaults=Scenario())
    return yaml_dump({name: yaml_load(data=text)})


def _find(name_or_file: str) -> tuple[Path, str]:
    known = library()
    if name_or_file in known:
        return known[name_or_file], name_or_file
    file, colon, wanted = name_or_file.rpartition(":")
    path = Path(file if colon else name_or_file)
    if not path.is_file():
        if path.suffix in {".yaml", ".yml"}:
            raise ScenarioError(f"{path}: no such file")
        raise ScenarioError(f"no scenario is called '{name_or_file}'; there are: {_list(known)}")
    names = list(_read(path))
    if colon and wanted not in names:
        raise ScenarioError(f"{path}: holds no scenario '{wanted}', only {_list(names)}")
    if not colon and len(names) != 1:
        raise ScenarioError(f"{path}: holds {_list(names)}; say which: {path}:{names[0]}")
    return path, wanted if colon else names[0]


def _read(path: Path) -> dict[str, Any]:
    try:
        contents = yaml_load(filename=str(path))
    except Exception as error:  # the parser raises its own kinds
        raise ScenarioError(f"{path}: not readable as YAML: {error}") from error
    if not isinstance(contents, dict) or not contents:
        raise ScenarioError(f"{path}: expected a mapping of names to scenarios")
    return contents


def _set(raw: dict[str, Any], override: str) -> None:
    path, _, value = override.partition("=")
    if not (path and value):
        raise ScenarioError(f"'{override}' is not of the form path.to.key=value ('' is empty text)")
    *parents, last = path.split(".")
    node: Any = raw
    try:
        for key in parents:
            node = node[int(key)] if isinstance(node, list) else node.setdefault(key, {})
        node[int(last) if isinstance(node, list) else last] = yaml_load(data=value)
    except Exception as error:  # as above, or no such place
        raise ScenarioError(f"'{override}' cannot be set: {error}") from error


def _parse(raw: dict[str, Any]) -> Scenario:
    scenario: Scenario = yaml_load_typed(schema=Scenario, data=yaml_dump(raw))
    return scenario


def _explain(error: Exception, raw: dict[str, Any]) -> str:
    """Name the entry that the loader stumbled over; it tells unknown keys without their parents."""
    said = str(error)
    place, value = _culprit(raw, said)
    where = ".".join(map(str, place))
    if not where:
        return said
    if value is None:
        return f"{where} is empty"
    if "unknown to the schema" in said:
        return f"unknown key {where}" if f"'{place[-1]}'" in said else f"{where}: {said}"
    reason = "" if isinstance(error, AssertionError) else f" ({said})"  # it only repeats the value
    return f"{where} cannot be {value!r}{reason}"


def _culprit(raw: dict[str, Any], said: str) -> tuple[Place, Any]:
    """Return the innermost entry without which the loader does not complain as it `said`."""
    place: Place = ()
    node: Any = raw
    relief = None  # what it says instead; taking away a good entry may be a mistake of its own
    while isinstance(node, dict | list):
        for key in node if isinstance(node, dict) else range(len(node)):
            complaint = _complaint(_without(raw, (*place, key)))
            if complaint != said and relief in (None, complaint):
                place, node, relief = (*place, key), node[key], complaint
                break
        else:
            break
    return place, node


def _complaint(raw: dict[str, Any]) -> str:
    try:
        _parse(raw)
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


def _list(names: Any) -> str:
    return ", ".join(names)
