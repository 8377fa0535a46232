"""The folders behind `package://NAME/…`, some of them within installed Python packages."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from scenarios.format.errors import NotInstalledError, ScenarioError

PYTHON = "python://"


def package_folder(name: str, place: str) -> Path:
    """Return the folder of a scenario's package: a path, or `python://MODULE/folder/within`.

    Raises NotInstalledError where the module is not installed, ScenarioError where there is no such
    folder.
    """
    folder = Path(place)
    if place.startswith(PYTHON):
        module, _, within = place.removeprefix(PYTHON).partition("/")
        spec = find_spec(module)
        if spec is None or not spec.submodule_search_locations:
            raise NotInstalledError(
                f"packages.{name}: {module} is not installed; pip install {module} (what scenarios "
                "of the library need is in contact-toolkit[models])"
            )
        folder = Path(spec.submodule_search_locations[0], within)
    if not folder.is_dir():
        raise ScenarioError(f"packages.{name}: {folder} is not a folder")
    return folder
