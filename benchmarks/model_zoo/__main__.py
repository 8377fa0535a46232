"""`python -m benchmarks.model_zoo`: run every model, write the README's table."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from benchmarks.model_zoo.files import all_files, listed_files, write_list
from benchmarks.model_zoo.run import BUDGET, fall_apart, loads_and_touches
from benchmarks.model_zoo.table import table
from scenarios.report.report import between_marks

README = Path(__file__).parents[2] / "README.md"


def main() -> None:
    """Search for models that Drake loads, or run those found before."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--search", action="store_true", help="look at every file; renew the list")
    parser.add_argument("--only", default="", help="part of a name")
    parser.add_argument("--budget", type=float, default=BUDGET, help="[s] of a core a model")
    parser.add_argument("--out", type=Path, help="write the results as JSON lines instead")
    arguments = parser.parse_args()
    if arguments.search:
        write_list([model for model in all_files() if loads_and_touches(model)])
        return
    falls = {}
    for model in (each for each in listed_files() if arguments.only in each.name):
        result = falls[model] = fall_apart(model, arguments.budget)
        print(f"{result.outcome:18} {model.name}  {result.reason}", flush=True)
        if arguments.out:
            with arguments.out.open("a") as out:
                out.write(json.dumps({"model": model.name, **result.as_dict()}) + "\n")
    if not arguments.out:
        before, _, after = between_marks(README, "model zoo")
        README.write_text(before + table(falls) + "\n" + after)


main()
