"""The child process of `decompose`: runs CoACD on a mesh file and writes the pieces.

Usage: decomposition_worker.py MESH.npz PIECES.npz PARAMETERS_AS_JSON. Stands alone: nothing of the
package is imported, so that starting it costs no more than CoACD itself.
"""

import json
import sys
from pathlib import Path

import numpy as np


def main(source: str, result: str, parameters: str) -> None:
    """Decompose the mesh in file `source` and write `points` (n, 3) and `first` to `result`."""
    import coacd  # noqa: PLC0415  not for those who import this module to know where it is

    with np.load(source, allow_pickle=False) as arrays:
        mesh = coacd.Mesh(arrays["vertices"], arrays["faces"])
    coacd.set_log_level("error")
    hulls = [points for points, _ in coacd.run_coacd(mesh, **json.loads(parameters))]
    first = np.cumsum([0, *map(len, hulls)], dtype=np.int32)
    beside = Path(result).with_suffix(".part.npz")
    np.savez(beside, points=np.concatenate(hulls), first=first)
    beside.replace(result)


if __name__ == "__main__":
    main(*sys.argv[1:])
