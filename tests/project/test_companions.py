"""Names that cannot clash, and clashes told of."""

import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

import contact_toolkit.drake
import contact_toolkit.parts
import scenarios.parts
import systems
from contact_toolkit.companions import import_companion

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("home", "package"),
    [(contact_toolkit.drake, systems), (contact_toolkit.parts, scenarios.parts)],
)
def test_every_public_name_has_one_more_home(home, package):
    # Another implementation, or a name that only the clashing package has.
    assert dir(home) == sorted(package.__all__)
    assert all(getattr(home, name) is getattr(package, name) for name in package.__all__)


def test_a_folder_in_the_way_is_named_with_ours(tmp_path, monkeypatch):
    # Otherwise the user reads that `systems` has no `AddNonlinearDamperContact`.
    theirs = tmp_path / "systems" / "__init__.py"
    theirs.parent.mkdir()
    theirs.touch()
    spec = spec_from_file_location("systems", theirs)
    monkeypatch.setitem(sys.modules, "systems", module_from_spec(spec))
    with pytest.raises(ImportError, match="shadowed") as caught:
        import_companion("systems")
    assert str(theirs) in str(caught.value)
    assert str(ROOT / "systems") in str(caught.value)


def test_the_package_is_the_command(tmp_path):
    # `contact-toolkit` is not on everyone's path.
    done = subprocess.run(
        [sys.executable, "-m", "contact_toolkit", "list"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "rock_n_stack" in done.stdout, done.stderr
