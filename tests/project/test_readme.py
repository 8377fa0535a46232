"""What the README promises on its first screen; its links and commands: test_docs.py."""

import re
import subprocess
import sys
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_README = (_ROOT / "README.md").read_text()


def test_the_example_runs_as_printed(tmp_path):
    """A newcomer's first copy and paste fails, or the egg is not where an egg should be."""
    (example,) = re.findall(r"```python\n(.*?)```", _README, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 15
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", example],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    x, y, z = (float(number) for number in run.stdout.strip("[] \n").split())
    assert abs(x) < 0.4
    assert abs(y) < 0.4
    assert 0.05 + 0.015 < z < 0.05 + 0.031  # on the table, upright or on its side
