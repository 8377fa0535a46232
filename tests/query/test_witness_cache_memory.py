"""A coherent query in its steady state allocates nothing: every malloc of the process is counted.

That covers the core and the Python call, from pose to rows, in a process of its own whose malloc
counts. It does not cover gathering, nor the array objects made when columns are read.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.engine

_SUPPORT = Path(__file__).parents[1] / "support"
_COMPILER = shutil.which("cc")

_QUERIES = """
import ctypes, gc, sys
import mesh_shapes, numpy as np
from contact_toolkit import CollisionMesh, WitnessCache
from poses import pose

allocations = ctypes.CDLL(None).allocations
A, B = CollisionMesh(*mesh_shapes.doughnut(32, 24)), CollisionMesh(*mesh_shapes.cone(32, 12))
standoff, merge, fresh = float(sys.argv[1]), sys.argv[2] == "merged", sys.argv[3] == "gathering"
cache = WitnessCache(A, B)
path = [pose(p=(1e-3, 1e-5 * np.sin(a), -0.178)) for a in np.linspace(0, 2 * np.pi, 32)]
rows = 0
gc.disable()
for lap in range(40):
    start = allocations()
    for X_AB in path:
        rows += len(cache.witness_pairs(X_AB, standoff, merge=merge))
    if fresh:
        cache = WitnessCache(A, B)
print(rows, allocations() - start)
"""


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    if sys.platform != "linux" or _COMPILER is None:
        pytest.skip("needs glibc and a C compiler")
    library = tmp_path_factory.mktemp("shim") / "malloc_count.so"
    source = _SUPPORT / "malloc_count.c"
    subprocess.run([_COMPILER, "-shared", "-fPIC", "-o", library, source], check=True)
    return library


def _last_lap(shim, *arguments):
    """Rows in all, and allocations in the last of many laps on a small circle."""
    environment = os.environ | {
        "LD_PRELOAD": str(shim),
        "PYTHONPATH": os.pathsep.join(sys.path),
        "PYTHONMALLOC": "default",  # not every object by itself, as sanitizers want them
    }
    command = [sys.executable, "-c", _QUERIES, *arguments]
    output = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    return map(int, output.stdout.split())


@pytest.mark.parametrize("merge", ["merged", "single"])
@pytest.mark.parametrize("standoff", ["0.002", "0.03"])
def test_steady_state(shim, standoff, merge):
    """A buffer made anew for a query, be it for a few rows or for thousands."""
    rows, allocations = _last_lap(shim, standoff, merge, "steady")
    assert rows > 1000
    assert allocations == 0


def test_gathering_is_seen(shim):
    """A counter that counts nothing."""
    _, allocations = _last_lap(shim, "0.002", "merged", "gathering")
    assert allocations > 0
