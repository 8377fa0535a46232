"""Where a run came from: versions, commit, host, date."""

from __future__ import annotations

import os
import platform
import shutil
import socket
import subprocess
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def versions() -> dict[str, str]:
    """Return the versions of what decides the numbers, and the machine."""
    return {
        "python": platform.python_version(),
        **decisive_versions(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
    }


def decisive_versions() -> dict[str, str]:
    """Return the versions of the packages that decide the numbers."""
    return {name: package_version(name) for name in ("contact-toolkit", "drake", "numpy", "scipy")}


def package_version(package: str) -> str:
    """Return the version of an installed package, or that it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"  # run from the sources


def commit() -> str:
    """Return the commit of the checkout this code runs from, `+` if it was changed; else ""."""
    git, folder = shutil.which("git"), Path(__file__).parents[2]
    if git is None or not (folder / ".git").exists():
        return ""  # installed, not a checkout
    try:
        found = subprocess.run(  # noqa: S603  fixed arguments
            [git, "-C", str(folder), "describe", "--always", "--dirty=+", "--abbrev=12"],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip()


def host() -> str:
    """Return the name of this machine."""
    return socket.gethostname()


def now() -> str:
    """Return the date and time, UTC, in ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
