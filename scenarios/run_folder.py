"""The folder of a run: written beside its target and put in place only when complete.

A run works in `.NAME.partial` beside NAME, which one process at a time may hold, and renames it
when it is done. So NAME is always one whole run, the earlier or the later one.
"""

from __future__ import annotations

import fcntl
import itertools
import os
import shutil
from pathlib import Path

from scenarios.format.errors import ScenarioError

MARK = "scenario.yaml"  # what every run folder holds


class RunFolder:
    """A run's target and the partial folder it is written in.

    Parameters
    ----------
    target
        Where the run shall be.
    replace
        Whether a run that is already there may be replaced; nothing but a run ever is.
    """

    def __init__(self, target: Path, *, replace: bool = False) -> None:
        self.target = target
        self._replace = replace
        self.partial = target.parent / f".{target.name}.partial"
        self._lock: int | None = None

    def open(self) -> Path:
        """Take the partial folder, empty, and return its path.

        Raises ScenarioError if the target cannot be made or may not be replaced, or if another run
        is at work on it.
        """
        if not self.target.name or self.target.name in (".", ".."):
            self.target = self.target.resolve()
            self.partial = self.target.parent / f".{self.target.name}.partial"
        self._check_target()
        try:
            self.target.parent.mkdir(parents=True, exist_ok=True)
            self.partial.mkdir(exist_ok=True)
            self._lock = os.open(self.partial, os.O_RDONLY)
        except OSError as error:
            raise ScenarioError(
                f"{self.target}: cannot be made: {error.strerror}; choose another folder with --out"
            ) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._release()
            raise ScenarioError(
                f"{self.target}: another run is writing it; wait for it, or choose another "
                "folder with --out"
            ) from None
        if not _is_same(self._lock, self.partial):  # the other was just renamed or removed
            self._release()
            return self.open()
        for left in self.partial.iterdir():  # by a run that was killed
            shutil.rmtree(left) if left.is_dir() and not left.is_symlink() else left.unlink()
        return self.partial

    def keep(self) -> Path:
        """Put the run in its place and return where that is.

        If another run has taken that place in the meantime, this one goes beside it.
        """
        try:
            self._check_target()
        except ScenarioError:
            self.target = _free_name_beside(self.target)
        old = self.target.parent / f".{self.target.name}.old"
        if self.target.exists():
            shutil.rmtree(old, ignore_errors=True)
            self.target.rename(old)
        self.partial.rename(self.target)
        shutil.rmtree(old, ignore_errors=True)
        self._release()
        return self.target

    def discard(self) -> None:
        """Remove what was written, if anything is open; the target stays as it was."""
        if self._lock is not None:
            shutil.rmtree(self.partial, ignore_errors=True)
            self._release()

    def _release(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _check_target(self) -> None:
        target = self.target
        if not os.path.lexists(target):
            return
        if not target.is_dir() or target.is_symlink():
            raise ScenarioError(
                f"{target}: File exists and is no folder; choose another with --out"
            )
        if not any(target.iterdir()):
            return
        if not (target / MARK).is_file():
            raise ScenarioError(
                f"{target}: holds files that are no run; choose another folder with --out"
            )
        if not self._replace:
            raise ScenarioError(
                f"{target}: holds an earlier run; --force replaces it, --out chooses another folder"
            )


def _free_name_beside(target: Path) -> Path:
    for number in itertools.count(2):
        beside = target.with_name(f"{target.name}-{number}")
        if not os.path.lexists(beside):
            return beside
    raise AssertionError


def _is_same(descriptor: int, path: Path) -> bool:
    try:
        there = path.stat()
    except FileNotFoundError:
        return False
    mine = os.fstat(descriptor)
    return (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino)
