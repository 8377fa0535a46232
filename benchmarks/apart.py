"""Work in a process of its own: a parser that aborts, or memory that stays, takes only itself."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any


def ask_apart(module: str, *arguments: str, time_out: float) -> dict[str, Any]:
    """Return the JSON object that ends what `python -m module arguments` prints.

    Raises TimeoutError after `time_out` [s], and ChildProcessError with the last line of its
    complaints where the process fails.
    """
    command = [sys.executable, "-m", module, *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=time_out, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise TimeoutError(f"hung for {time_out:g} s") from error
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise ChildProcessError(f"the process ended: {last[0]}")
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer
