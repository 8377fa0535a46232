"""Programs that are interrupted by Ctrl-C once they have said a word."""

import os
import signal
import subprocess
import sys


def interrupted_at(word: str, program: str, *arguments: str) -> str:
    """Return all that a Python program said, which must end as Ctrl-C ends programs."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    said = ""
    while word not in said:
        line = process.stdout.readline()
        assert line, said
        said += line
    os.kill(process.pid, signal.SIGINT)
    said += process.communicate(timeout=120)[0]
    assert process.returncode == 130, said
    assert "Traceback" not in said
    return said
