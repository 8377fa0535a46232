"""A slice of a peg-in-hole C-space: what `classify` finds, against the exact boundary.

A rectangular peg stands partly inserted in a slot; the slice is over sideways position and tilt.
Run `python notebooks/cspace_slice.py [PICTURE.png]`.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from scipy.spatial.transform import Rotation

from contact_toolkit import ConvexPieces, CSpaceClass, CSpaceModel, classify
from scenarios.parts import box

PEG, SLOT, LENGTH = 9.8e-3, 10e-3, 40e-3  # [m] widths of the peg and the slot; the peg's length
INSERTED = 10e-3  # [m] depth of the peg's tip
STANDOFF = 20e-6  # [m]


def make_model():
    """The slot as two walls far thicker than the peg, and the peg about the middle of its tip."""
    wall = box(0.1, 0.02, 0.1)[0]
    x = SLOT / 2 + 0.05
    walls = ConvexPieces([wall + np.array([side * x, 0, -0.05]) for side in (-1, 1)])
    peg = ConvexPieces([box(PEG, 0.02, LENGTH)[0] + np.array([0, 0, LENGTH / 2])])
    return CSpaceModel.from_shapes({"slot": walls, "peg": peg})


def classify_grid(model, x, tilt):
    """The class of each (tilt, x), and the distance [m]."""
    across, turned = np.meshgrid(x, tilt)
    X_FB = np.tile(np.eye(4), (across.size, 2, 1, 1))
    X_FB[:, 1, :3, :3] = Rotation.from_rotvec(np.outer(turned.ravel(), [0, 1, 0])).as_matrix()
    X_FB[:, 1, 0, 3], X_FB[:, 1, 2, 3] = across.ravel(), -INSERTED
    found = classify(model, X_FB, standoff=STANDOFF)
    return found.kind.reshape(across.shape), found.distance.reshape(across.shape)


def exact_play(tilt):
    """Least and greatest free x [m] at each tilt, in closed form.

    The peg's part below the slot's rim must stay between the walls: its extreme points are corners
    of the tip, or where the sides pass the rim.
    """
    c, s = np.cos(tilt), np.sin(tilt)
    low, high = np.full(tilt.shape, np.inf), np.full(tilt.shape, -np.inf)
    for side in (-PEG / 2, PEG / 2):
        tip = side * c  # a corner, from the middle of the tip; its height over that is -side s
        rim = tip + np.clip(INSERTED + side * s, 0, None) / c * s
        below = INSERTED + side * s > 0
        low = np.minimum(low, np.where(below, np.minimum(tip, rim), np.inf))
        high = np.maximum(high, np.where(below, np.maximum(tip, rim), -np.inf))
    return -SLOT / 2 - low, SLOT / 2 - high


def draw(path, x, tilt, kind, play):
    """Save the picture."""
    colours = ListedColormap(["#ffffff", "#f4c95d", "#8a9bb0"])
    figure, axes = plt.subplots(figsize=(7, 4.2), layout="constrained")
    axes.pcolormesh(x * 1e3, np.degrees(tilt), kind, cmap=colours, vmin=0, vmax=2)
    open_ = play[0] < play[1]
    outline = np.concatenate([play[0][open_], play[1][open_][::-1]]) * 1e3
    angles = np.degrees(np.concatenate([tilt[open_], tilt[open_][::-1]]))
    axes.plot(np.append(outline, outline[0]), np.append(angles, angles[0]), "k", lw=1)
    for colour, label in zip(
        colours.colors, ("free", f"within {STANDOFF * 1e6:g} µm", "colliding"), strict=True
    ):
        axes.plot([], [], "s", color=colour, markeredgecolor="k", label=label)
    axes.plot([], [], "k", lw=1, label="exact boundary")
    axes.set_xlabel("sideways [mm]")
    axes.set_ylabel("tilt [°]")
    axes.set_title(f"{PEG * 1e3:g} mm peg, {INSERTED * 1e3:g} mm deep in a {SLOT * 1e3:g} mm slot")
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main(path, cells=400):
    """Draw the slice and return the fraction of cells that differ from the exact C-space."""
    x, tilt = np.linspace(-0.15e-3, 0.15e-3, cells), np.radians(np.linspace(-1.6, 1.6, cells))
    kind, _ = classify_grid(make_model(), x, tilt)
    play = exact_play(tilt)
    free = (x > play[0][:, None]) & (x < play[1][:, None])
    draw(path, x, tilt, kind, play)
    return float(np.mean((kind != CSpaceClass.COLLIDING) != free))


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "cspace_slice.png")
    print(f"{target}: {main(target):.2%} of the cells differ from the exact C-space")
