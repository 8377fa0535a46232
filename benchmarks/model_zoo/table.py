"""The README's table of models."""

from __future__ import annotations

import math
from collections.abc import Mapping

from benchmarks.model_zoo.fall import AT_REST, Fall
from benchmarks.model_zoo.files import ModelFile


def table(falls: Mapping[ModelFile, Fall]) -> str:
    """Return the table in Markdown, one row a model."""
    rows = ["| model | after 1 s | forces against weight | × real time |", "|---|---|---|---|"]
    for model, each in falls.items():
        rows.append(
            f"| {model.name} | {_state(each)} | {_percent(each.imbalance)} "
            f"| {_figure(each.real_time_factor)} |"
        )
    ran = sum(each.outcome == "ran" for each in falls.values())
    return f"{ran} of {len(falls)} run.\n\n" + "\n".join(rows)


def _state(each: Fall) -> str:
    if each.outcome != "ran":
        reason = each.reason.split(". ", 1)[0]  # the rest names files of this machine
        return f"{each.outcome}: {reason}".replace("|", "/")
    return "at rest" if each.speed < AT_REST else f"moves, {each.speed:.2g} m/s"


def _percent(share: float) -> str:
    return "–" if math.isnan(share) else f"{100 * share:+.2f} %"


def _figure(factor: float) -> str:
    return "–" if math.isnan(factor) else f"{factor:.2g}"
