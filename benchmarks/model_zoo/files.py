"""Where the model files are, and what Drake needs to read them."""

from __future__ import annotations

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path

from pydrake.multibody.parsing import PackageMap, Parser
from pydrake.multibody.plant import MultibodyPlant

# Folder of each package's models, relative to where it is installed.
PACKAGES = {
    "manipulation": "manipulation/models",
    "example-robot-data": "cmeel.prefix/share/example-robot-data",
    "robosuite": "robosuite/models/assets",
    "gymnasium-robotics": "gymnasium_robotics/envs",
    "mujoco": "mujoco",
}
_SUFFIXES = {".urdf", ".sdf", ".xml"}
_LIST = Path(__file__).with_name("files.txt")


@dataclass(frozen=True)
class ModelFile:
    """One file of one package.

    Attributes
    ----------
    package
        As pip calls it.
    path
        Within the package's folder of models.
    """

    package: str
    path: str

    @property
    def name(self) -> str:
        """For tables and tests."""
        return f"{self.package}/{self.path}"


def folder_of(package: str) -> Path | None:
    """Return the folder of a package's models; None where it is not installed."""
    try:
        distribution = importlib.metadata.distribution(package)
    except importlib.metadata.PackageNotFoundError:
        return None
    return Path(str(distribution.locate_file(PACKAGES[package])))


def all_files() -> list[ModelFile]:
    """Return every file of the installed packages that looks like a model."""
    return [
        ModelFile(package, path.relative_to(folder).as_posix())
        for package in PACKAGES
        if (folder := folder_of(package)) is not None
        for path in sorted(folder.rglob("*"))
        if path.suffix in _SUFFIXES and path.name != "package.xml"
    ]


def listed_files() -> list[ModelFile]:
    """Return the files that Drake loads and that can touch a table, as `--search` found them."""
    return [ModelFile(*line.split(maxsplit=1)) for line in _LIST.read_text().splitlines()]


def write_list(files: list[ModelFile]) -> None:
    """Replace what `listed_files` returns."""
    _LIST.write_text("".join(f"{each.package} {each.path}\n" for each in files))


def make_parser(plant: MultibodyPlant, package: str) -> Parser:
    """Return a parser that knows a package's folder; raises where it is not installed."""
    folder = folder_of(package)
    if folder is None:
        raise FileNotFoundError(f"{package} is not installed: pip install {package}")
    parser = Parser(plant)
    packages: PackageMap = parser.package_map()
    packages.Remove("drake_models")  # would be fetched: hundreds of megabytes, or a long wait
    packages.PopulateFromFolder(str(folder))
    if not packages.Contains(package):
        packages.Add(package, str(folder))
    parser.SetAutoRenaming(True)
    return parser


def add_model(plant: MultibodyPlant, model: ModelFile) -> None:
    """Parse a model; raises what Drake raises."""
    make_parser(plant, model.package).AddModels(str(folder_of(model.package)) + "/" + model.path)
