"""What a run comes down to: `summary.json`."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from scenarios.format.errors import ScenarioError
from scenarios.judge.acceptance import Check
from scenarios.judge.verdicts import PASSED, SKIPPED, UNJUDGED


@dataclass
class Summary:
    """Figures, counts and verdict of one run. Times in [s].

    The verdict is "passed" or "failed" by the scenario's acceptance, "not judged" without one,
    "interrupted" or "error" if the run did not finish, "skipped" if what it needs is not installed;
    `error` says why, and also why figures that
    a verdict needs do not exist.
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
    warnings: list[str] = field(default_factory=list)
    overrides: list[str] = field(default_factory=list)
    truth: str = ""
    date: str = ""
    commit: str = ""
    host: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    folder: str = ""

    @property
    def acceptable(self) -> bool:
        """Whether the run did not fail."""
        return self.verdict in {PASSED, UNJUDGED, SKIPPED}

    def save(self, folder: Path) -> None:
        """Write `summary.json` into a run folder."""
        contents = _finite(asdict(self))
        del contents["folder"]  # which may be moved
        text = json.dumps(contents, indent=2, allow_nan=False)
        (folder / "summary.json").write_text(text + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> Summary:
        """Read `summary.json`; raise ScenarioError if the folder holds none that can be read."""
        path = folder / "summary.json"
        if not path.is_file():
            raise ScenarioError(f"{folder}: not a run folder, it has no summary.json")
        try:
            contents: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            contents["checks"] = [Check(**_numbers(check)) for check in contents["checks"]]
            contents["figures"] = _numbers(contents["figures"])
            return cls(**contents, folder=str(folder))
        except (ValueError, KeyError, TypeError) as error:
            raise ScenarioError(
                f"{path}: not the summary of a run ({error}); run the scenario again"
            ) from error


def _finite(node: Any) -> Any:
    """Replace numbers that JSON has none for by null."""
    if isinstance(node, dict):
        return {key: _finite(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_finite(value) for value in node]
    return None if isinstance(node, float) and not math.isfinite(node) else node


def _numbers(figures: dict[str, Any]) -> dict[str, Any]:
    return {key: math.nan if value is None else value for key, value in figures.items()}
