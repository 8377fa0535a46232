"""The layout shows the architecture: arrows run only downwards, in C++ as in Python."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CPP = ROOT / "contact_toolkit" / "cpp"

# Each may include what stands to its left; those in one place know nothing of each other.
FOLDERS = [
    {"base"},
    {"math"},
    {"shapes"},
    {"kernels"},
    {"query/witness", "query/point"},
    {"query/cache", "query/solid", "query/swept"},
    {"web"},
    {"web/area"},
    {"contact"},
    {"step"},
    {"bindings"},
]
RANK = {folder: rank for rank, folders in enumerate(FOLDERS) for folder in folders}


def test_no_include_runs_upwards():
    # An engine whose lower half needs its upper half cannot be read, tested or reused in parts.
    upwards = []
    for file in sorted([*CPP.rglob("*.h"), *CPP.rglob("*.cpp")]):
        here = file.parent.relative_to(CPP).as_posix()
        for included in re.findall(r'^#include "(.*)"', file.read_text(), re.MULTILINE):
            there = Path(included).parent.as_posix()
            if there != here and not RANK[there] < RANK[here]:
                upwards.append(f"{file.relative_to(CPP)} includes {included}")
    assert not upwards


@pytest.mark.parametrize("package", ["contact_toolkit", "systems", "scenarios"])
def test_modules_do_not_import_the_face_of_their_own_package(package):
    # The face imports every module: a module that imports it back works or not by the order.
    imports = re.compile(rf"^\s*from {package} import (.*)|^\s*import ({package})\b", re.MULTILINE)
    guilty = [
        str(file.relative_to(ROOT))
        for file in sorted((ROOT / package).rglob("*.py"))
        for names, whole in imports.findall(file.read_text())
        if whole or names.strip() != "_core"
    ]
    assert not guilty


def test_the_readme_names_every_folder():
    # A file is found from its subject by the table of folders; a folder left out is found by luck.
    readme = (ROOT / "README.md").read_text()
    folders = {
        f"{path.relative_to(ROOT).as_posix()}/"
        for package in ("contact_toolkit", "contact_toolkit/cpp", "systems", "scenarios", "tests")
        for path in (ROOT / package).iterdir()
        if path.is_dir() and path.name != "__pycache__"
    }
    assert not sorted(folder for folder in folders if folder not in readme)
