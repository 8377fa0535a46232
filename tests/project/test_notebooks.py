"""The notebooks run from top to bottom without a warning, and match their paired scripts."""

from pathlib import Path

import jupytext
import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
SLOW = {"05_rock_n_stack"}  # simulates two times five seconds; `make docs` executes it too


def outputs_of(notebook):
    return [output for cell in notebook.cells for output in cell.get("outputs", [])]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_and_script_are_the_same_program(path):
    cells, paired = (
        [(cell.cell_type, cell.source) for cell in jupytext.read(file).cells]
        for file in (path, path.with_suffix(".py"))
    )
    assert cells == paired, f"run: jupytext --sync {path.with_suffix('.py')}"


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem in SLOW else [])
        for path in NOTEBOOKS
    ],
)
def test_notebook_runs_without_warnings(path, tmp_path, monkeypatch):
    notebook = execute(path, tmp_path, monkeypatch)
    outputs = outputs_of(notebook)
    said = "".join(output.text for output in outputs if output.get("name") == "stderr")
    assert "Warning" not in said
    if any("IFrame" in cell.source for cell in notebook.cells):
        assert list((tmp_path / "runs").glob("*.html"))  # the playback shown inline
    for table in (o.text for o in outputs if "closed form" in o.get("text", "")):
        rows = [[float(number) for number in line.split()] for line in table.splitlines()[1:]]
        assert len(rows) >= 5
        for _, measured, expected in rows:
            assert measured == pytest.approx(expected, rel=0.01)


def execute(path, folder, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    notebook = nbformat.read(path, as_version=4)
    where = {"metadata": {"path": folder}}
    client = NotebookClient(
        notebook, timeout=900, kernel_name="python3", resources=where, coalesce_streams=True
    )
    return client.execute()
