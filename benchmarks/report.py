"""The results as a table in Markdown and as JSON, with the machine and the versions."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from benchmarks.harness import Row, Stopwatch
from contact_toolkit import _core

_PACKAGES = ("coal", "python-fcl", "numpy")


def write_results(rows: Iterable[Row], watch: Stopwatch, folder: Path) -> None:
    """Write RESULTS.md and results.json into a folder."""
    rows = list(rows)
    about = _about(watch)
    records = [{**asdict(row), "ratio": row.ratio} for row in rows]
    (folder / "results.json").write_text(json.dumps({**about, "rows": records}, indent=1) + "\n")
    (folder / "RESULTS.md").write_text(_markdown(rows, about))


def as_line(row: Row) -> str:
    """Return a row as text for the terminal."""
    verdict = "" if row.target is None else f"at least {row.target:.2g}"
    if row.target is not None and row.ratio < row.target:
        verdict += "  MISSED"
    return (
        f"  {row.case:58} {_duration(row.seconds):>9} {_duration(row.yardstick_seconds):>9} "
        f"{row.yardstick:14} {row.ratio:7.2f}  {verdict}"
    )


def _markdown(rows: list[Row], about: dict[str, object]) -> str:
    lines = [
        "# Results",
        "",
        "Ratio: how many times faster than the yardstick, both medians of interleaved runs in one",
        "process; in bold where the target is missed. What each benchmark is for: README.md.",
        "",
        *(f"- {key}: {value}" for key, value in about.items()),
        "",
        "![Ratios to coal and FCL](ratios.png)",
        "",
        "![Growth with the number of facets](growth.png)",
    ]
    tables: dict[str, list[Row]] = {}
    for row in rows:
        tables.setdefault(row.benchmark, []).append(row)
    for name, table in tables.items():
        lines += [
            "",
            f"## {name[0].upper()}{name[1:]}",
            "",
            "| case | in | out | time | yardstick | its time | ratio | target |",
            "|---|--:|--:|--:|---|--:|--:|--:|",
            *map(_markdown_line, table),
        ]
    return "\n".join(lines) + "\n"


def _markdown_line(row: Row) -> str:
    missed = row.target is not None and row.ratio < row.target
    ratio = f"**{row.ratio:.2f}**" if missed else f"{row.ratio:.2f}"
    cells = [
        row.case,
        "" if row.size is None else str(row.size),
        "" if row.output is None else str(row.output),
        _duration(row.seconds),
        row.yardstick,
        _duration(row.yardstick_seconds),
        ratio,
        "" if row.target is None else f"{row.target:.2g}",
    ]
    return "| " + " | ".join(cells) + " |"


def _duration(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def _about(watch: Stopwatch) -> dict[str, object]:
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "processor": f"{_processor()}, {os.cpu_count()} logical cores",
        "instructions": _core.simd(),
        "python": platform.python_version(),
        "versions": ", ".join(f"{name} {version(name)}" for name in _PACKAGES),
        "runs": watch.runs,
        "clock": watch.clock.__name__,
    }


def _processor() -> str:
    try:
        described = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    facts = dict(line.split(":", 1) for line in described.splitlines() if ":" in line)
    return {key.strip(): value.strip() for key, value in facts.items()}.get("model name", "unknown")
