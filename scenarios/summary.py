"""What a run comes down to: `summary.json`."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from scenarios.acceptance import PASSED, UNJUDGED, Check
from scenarios.errors import ScenarioError


@dataclass
class Summary:
    """Figures, counts and verdict of one run. Times in [s].

    The verdict is "passed" or "failed" by the scenario's acceptance, "not judged" without one,
    "interrupted" or "crashed" (then `error` says why) if the run did not finish.
    """

    scenario: str
    verdict: str = UNJUDGED
    error: str = ""
    figures: dict[str, float] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    simulated_time: float = 0.0
    wall_time: float = 0.0
    real_time_factor: float = 0.0
    force_evaluations: int = 0
    steps: int = 0
    random_seed: int = 0
    versions: dict[str, str] = field(default_factory=dict)

    @property
    def acceptable(self) -> bool:
        """Whether the run finished and did not fail."""
        return self.verdict in {PASSED, UNJUDGED}

    def save(self, folder: Path) -> None:
        """Write `summary.json` into a run folder."""
        text = json.dumps(asdict(self), indent=2)
        (folder / "summary.json").write_text(text + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> Summary:
        """Read `summary.json`; raise ScenarioError if the folder holds none that can be read."""
        path = folder / "summary.json"
        if not path.is_file():
            raise ScenarioError(f"{folder}: not a run folder, it has no summary.json")
        try:
            contents: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            contents["checks"] = [Check(**check) for check in contents["checks"]]
            return cls(**contents)
        except (ValueError, KeyError, TypeError) as error:
            raise ScenarioError(
                f"{path}: not the summary of a run ({error}); run the scenario again"
            ) from error


def versions() -> dict[str, str]:
    """Return the versions of what decides the numbers, and the machine."""
    return {
        "python": platform.python_version(),
        **{name: _version(name) for name in ("contact-toolkit", "drake", "numpy", "scipy")},
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"  # run from the sources
