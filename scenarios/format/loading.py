"""Find scenarios by name or file and load them, with overrides and errors that say where."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load

from scenarios.format.checks import check
from scenarios.format.errors import ScenarioError
from scenarios.format.paths import named_files, resolve_paths
from scenarios.format.scenario import Scenario
from scenarios.format.typed import read_mapping, typed

LIBRARY = Path(__file__).parents[1] / "library"


def library() -> dict[str, Path]:
    """Return the names of the scenarios that come with the project, and their files."""
    return {name: path for path in sorted(LIBRARY.glob("*.yaml")) for name in read_mapping(path)}


@dataclass(frozen=True)
class RawScenario:
    """A scenario as its file has it, ready for overrides; see `find`."""

    name: str
    raw: dict[str, Any]
    path: Path
    """Of the file, which its paths are relative to."""

    def digest(self) -> str:
        """Return a hash of what it says and of the model and mesh files that it names itself."""
        said = hashlib.blake2b(json.dumps(self.raw, sort_keys=True).encode(), digest_size=16)
        for path in named_files(resolve_paths(self.raw, self.path.parent)):
            said.update(path.read_bytes() if path.is_file() else b"")
        return said.hexdigest()

    def load(self, overrides: Sequence[str] = ()) -> Scenario:
        """Return the scenario; overrides are `path.to.key=value`, the value in YAML.

        Raises ScenarioError naming the file and the key.
        """
        where, raw = f"{self.path}: {self.name}", deepcopy(self.raw)
        for override in overrides:
            _set(raw, override)
        scenario = typed(Scenario, resolve_paths(raw, self.path.parent), where)
        try:
            check(scenario)
        except ScenarioError as error:
            raise ScenarioError(f"{where}: {error}") from error
        return scenario


def find(name_or_file: str) -> RawScenario:
    """Return a scenario of the library or of a YAML file, not yet converted.

    A file maps names to scenarios; where it holds several, say which: `FILE:NAME`.
    """
    path, name = _find(name_or_file)
    raw = read_mapping(path)[name]
    if not isinstance(raw, dict):
        raise ScenarioError(f"{path}: {name}: expected the keys of a scenario, found {raw!r}")
    return RawScenario(name, raw, path.resolve())


def load(name_or_file: str, overrides: Sequence[str] = ()) -> tuple[str, Scenario]:
    """Return the name and contents of a scenario: `find`, then `RawScenario.load`."""
    found = find(name_or_file)
    return found.name, found.load(overrides)


def dump(name: str, scenario: Scenario) -> str:
    """Return the YAML that `load` turns into the same scenario, defaults included."""
    text = yaml_dump_typed(scenario, schema=Scenario)
    return yaml_dump({name: yaml_load(data=text)})


def _find(name_or_file: str) -> tuple[Path, str]:
    file, colon, wanted = name_or_file.rpartition(":")
    path = Path(file if colon else name_or_file)
    if path.suffix not in {".yaml", ".yml"}:  # else a file: the library need not be read
        known = library()
        if name_or_file in known:
            return known[name_or_file], name_or_file
        if not path.is_file():
            raise ScenarioError(
                f"no scenario is called '{name_or_file}'; there are: {_list(known)}"
            )
    elif not path.is_file():
        raise ScenarioError(f"{path}: no such file")
    names = list(read_mapping(path))
    if colon and wanted not in names:
        raise ScenarioError(f"{path}: holds no scenario '{wanted}', only {_list(names)}")
    if not colon and len(names) != 1:
        raise ScenarioError(f"{path}: holds {_list(names)}; say which: {path}:{names[0]}")
    return path, wanted if colon else names[0]


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


def _list(names: Any) -> str:
    return ", ".join(names)
