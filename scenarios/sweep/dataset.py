"""The rows of a sweep: a folder of Parquet files, each whole or absent.

`sweep.json` says what was asked; `rows/*.parquet` hold the rows. One sweep at a time may write.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.format.errors import ScenarioError
from scenarios.sweep.plan import COLUMNS, Plan

MARK = "sweep.json"
_KINDS = {str: pa.string(), int: pa.int64(), float: pa.float64()}


class Dataset:
    """The folder of a sweep. Its rows are those of `plan`, in the order in which they finished."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder, self.plan = folder, plan
        self.schema = schema_of(plan)

    @classmethod
    def load(cls, folder: Path) -> Dataset:
        """Return the dataset of a sweep; raise ScenarioError if the folder holds none."""
        path = folder / MARK
        if not is_sweep(folder):
            raise ScenarioError(f"{folder}: not the folder of a sweep, it has no {MARK}")
        try:
            return cls(folder, Plan.again(json.loads(path.read_text(encoding="utf-8"))))
        except (ValueError, KeyError, TypeError) as error:
            raise ScenarioError(f"{path}: does not describe a sweep: {error}") from error

    @contextmanager
    def writing(self, *, resume: bool) -> Iterator[None]:
        """Hold the folder for writing, made or taken up again.

        Raises ScenarioError if another sweep is writing to it, if it holds rows that were not asked
        to be resumed, rows of other contents, or something else.
        """
        if self.folder.is_dir() and not is_sweep(self.folder) and _holds(self.folder):
            raise ScenarioError(
                f"{self.folder}: holds files that are no sweep; choose another with --out"
            )
        (self.folder / "rows").mkdir(parents=True, exist_ok=True)
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise ScenarioError(
                    f"{self.folder}: another sweep is writing to it; wait for it, or choose "
                    "another folder with --out"
                ) from None
            self._take_up(resume)
            yield
        finally:
            os.close(lock)

    def _take_up(self, resume: bool) -> None:
        path = self.folder / MARK
        if path.is_file():
            if not resume:
                raise ScenarioError(
                    f"{self.folder}: holds an earlier sweep; --resume goes on with it, --out "
                    "chooses another folder"
                )
            there, mine = Dataset.load(self.folder), self.plan.identity
            before = json.loads(path.read_text(encoding="utf-8"))["identity"]
            changed = [key for key in mine if mine[key] != before.get(key)]
            if changed or there.schema != self.schema:
                raise ScenarioError(
                    f"{self.folder}: its rows are of another sweep: {_told(changed)} changed "
                    "since; undo that, or choose another folder with --out"
                )
        for left in (self.folder / "rows").glob(".*.tmp"):  # by a sweep that was killed
            left.unlink()
        _write(path, json.dumps(self.plan.describe(), indent=1).encode())

    def read(self) -> pa.Table:
        """Return all rows in the order of the runs; raise ScenarioError naming a corrupt file."""
        tables = [_read(path, self.schema) for path in self.parts()]
        table = pa.concat_tables([self.schema.empty_table(), *tables])
        return table.sort_by("run")

    def columns(self, *names: str) -> list[list[Any]]:
        """Return some columns of all rows."""
        table = self.read()
        return [table[name].to_pylist() for name in names]

    def parts(self) -> list[Path]:
        """Return the files that hold the rows."""
        return sorted((self.folder / "rows").glob("[!.]*.parquet"))

    def add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows as one more file, all or none; OSError where the disk does not take them."""
        table = pa.Table.from_pylist([dict(row) for row in rows], schema=self.schema)
        sink = pa.BufferOutputStream()
        pq.write_table(table, sink, write_page_checksum=True)
        number = 1 + max((int(path.stem) for path in self.parts()), default=0)
        _write(self.folder / "rows" / f"{number:06}.parquet", sink.getvalue())


def is_sweep(folder: Path) -> bool:
    """Whether a folder is that of a sweep."""
    return (folder / MARK).is_file()


def schema_of(plan: Plan) -> pa.Schema:
    """Return the columns: those of every sweep, the inputs and the figures, told apart by role."""
    roles = [
        *(pa.field(name, _KINDS[kind]) for name, kind in COLUMNS.items()),
        *(
            pa.field(name, pa.string() if p.choices else pa.float64(), metadata={"role": "input"})
            for name, p in plan.study.parameters.items()
        ),
        *(pa.field(name, pa.float64(), metadata={"role": "figure"}) for name in plan.figures),
    ]
    return pa.schema(roles)


def _read(path: Path, schema: pa.Schema) -> pa.Table:
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            table = file.read()
        if table.schema != schema:
            raise pa.ArrowInvalid("its columns are not those of the sweep")
    except (OSError, pa.ArrowException) as error:
        raise ScenarioError(
            f"{path}: cannot be read ({str(error).splitlines()[0]}); remove this file, and "
            "--resume repeats its runs"
        ) from error
    return table


def _write(path: Path, contents: Any) -> None:
    """Put a file in place whole, safe from a loss of power."""
    partial = path.with_name(f".{path.name}.tmp")
    try:
        with partial.open("wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        partial.rename(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        error.filename = error.filename or str(path)  # a full disk does not say where
        raise


def _holds(folder: Path) -> bool:
    return any(path.name != "rows" or any(path.iterdir()) for path in folder.iterdir())


def _told(changed: Sequence[str]) -> str:
    said = {"contents": "the scenario file", "versions": "the installed versions"}
    return ", ".join(said.get(key, key) for key in changed) or "its columns"
