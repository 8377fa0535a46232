"""Experiments as YAML, their acceptance checks, the runner and the command line.

`scenarios.rollout` runs one from Python: see `scenarios.sweep.rollout`.
"""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    # Drake takes a second to import, and the command line imports this first.
    if name == "rollout":
        from scenarios.sweep.rollout import rollout

        return rollout
    raise AttributeError(f"module 'scenarios' has no attribute '{name}'")
