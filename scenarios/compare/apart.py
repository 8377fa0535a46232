"""An engine's run in a process of its own, which may hang or crash without the others.

As a program it is that process: `python -m scenarios.compare.apart ENGINE SCENARIO.yaml ANSWER`.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from pathlib import Path
from tempfile import TemporaryDirectory

from scenarios.compare.outcome import Outcome
from scenarios.judge.verdicts import TIMED_OUT


def run_apart(engine: str, scenario_file: Path, time_out: float) -> Outcome:
    """Return what an engine made of a scenario, or why it made nothing of it.

    Whatever ends this early, as Ctrl-C does, ends the engine too.
    """
    with TemporaryDirectory() as folder:
        answer, said = Path(folder, "answer"), Path(folder, "said")
        command = [sys.executable, "-m", __name__, engine, str(scenario_file), str(answer)]
        with (
            said.open("w") as out,
            subprocess.Popen(  # noqa: S603  nothing in the command but names of ours
                command, stdin=subprocess.PIPE, stdout=out, stderr=out, start_new_session=True
            ) as process,
        ):
            try:
                process.wait(time_out)
            except subprocess.TimeoutExpired:
                return Outcome(engine, verdict=TIMED_OUT, error=f"not done in {time_out:g} s")
            finally:
                process.kill()
                process.wait()
        if answer.is_file():
            outcome = pickle.loads(answer.read_bytes())  # noqa: S301  of our own process
            assert isinstance(outcome, Outcome)
            return outcome
        code = process.returncode
        died = f"by {signal.Signals(-code).name}" if code < 0 else f"with status {code}"
        last = said.read_text(errors="replace").strip().rpartition("\n")[2]
        return Outcome(engine, verdict="cannot", error=f"died {died}: {last}")


def _run(engine: str, scenario_file: str, answer: Path) -> None:
    from scenarios.compare.engines import engines
    from scenarios.format.loading import load

    try:
        outcome = engines()[engine](load(scenario_file)[1])
    except Exception as error:  # noqa: BLE001  what an engine cannot do is a result
        told = str(error).splitlines()[0] if str(error) else type(error).__name__
        outcome = Outcome(engine, verdict="cannot", error=told)
    whole = answer.with_suffix(".partial")
    whole.write_bytes(pickle.dumps(outcome))
    whole.rename(answer)


def _end_with_input() -> None:
    sys.stdin.read()
    os._exit(0)  # whoever waited for the answer is gone


if __name__ == "__main__":
    threading.Thread(target=_end_with_input, daemon=True).start()
    _run(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
