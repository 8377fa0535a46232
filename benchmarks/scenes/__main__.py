"""`python -m benchmarks.scenes`: run every scene under every contact, write the tables."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from benchmarks.discrete_steps import ENGINES
from benchmarks.scenes.run import SCENES, Result, run_apart
from benchmarks.scenes.table import document, short_table
from scenarios.report.report import between_marks

FOLDER = Path(__file__).parents[1]
README = FOLDER.parent / "README.md"


def main() -> None:
    """Run them all; or some, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="part of a name: runs these, writes nothing")
    parser.add_argument("--engine", choices=ENGINES, help="runs this alone, writes nothing")
    arguments = parser.parse_args()
    results: dict[str, dict[str, Result]] = {}
    for name in (each for each in SCENES if arguments.only in each):
        for engine in [arguments.engine] if arguments.engine else ENGINES:
            result = run_apart(SCENES[name], engine)
            results.setdefault(name, {})[engine] = result
            print(json.dumps({"scene": name, "engine": engine, **asdict(result)}), flush=True)
    if not (arguments.only or arguments.engine):
        (FOLDER / "SCENES.md").write_text(document(results))
        before, _, after = between_marks(README, "scenes")
        README.write_text(before + short_table(results) + after)


main()
