"""The core without Drake: `pip install --no-deps contact-toolkit` beside numpy."""

import subprocess
import sys

PROGRAM = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {forbidden}:
            raise ImportError(f"{{name}} is not installed")

sys.meta_path.insert(0, Refuse())
import numpy as np
import contact_toolkit as ct

corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
tetrahedron = ct.CollisionMesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
X_AB = np.eye(4)
X_AB[0, 3] = 1.25
print(ct.distance(tetrahedron, tetrahedron, X_AB).distance)
geometries = [ct.ContactGeometry(name, name, tetrahedron) for name in ("a", "b")]
pair = ct.ContactPair(0, 1, ct.NonlinearDamper(k=1e6))
model = ct.ContactModel(["a", "b"], geometries, [pair])
X_AB[0, 3] = 0.99
forces = model.evaluate(np.stack([np.eye(4), X_AB]), np.zeros((2, 6)))
print(float(np.linalg.norm(forces.body_wrenches[0, 3:])) > 0)
"""

FORBIDDEN = [
    "scipy",
    "trimesh",
    "coacd",
    "meshcat",
    "pydrake",
    "typer",
    "rich",
    "matplotlib",
    "pyarrow",
]


def test_queries_and_contact_work_with_numpy_alone():
    # Otherwise a planner that only asks for distances has to install Drake.
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(forbidden=FORBIDDEN)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["0.25", "True"]
