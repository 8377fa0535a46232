"""InitialOverlap: what to do about bodies that overlap when a simulation begins."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import ContactModel, ContactState, Forces
from systems.diagnostics.common_inside import CommonInside
from systems.diagnostics.joint_hold import JointHold
from systems.plant.whole_bodies import WholeBodies, joint_trees

Floats = NDArray[np.float64]

POLICIES = ("ease", "filter", "warn", "raise")
# Of the smaller body's diagonal: half of its skin. Nothing lies or is held as deep, unless it is
# soft; and of the weight of the lighter body, which tells what is soft from what overlaps.
_DEEP = 5e-3
_HEAVY = 10.0
_LISTED = 6  # pairs listed in the warning; a scene of bricks may have hundreds


@dataclass(frozen=True)
class Overlap:
    """A pair of geometries that overlap.

    Attributes
    ----------
    pair
        In the contact model.
    depth, force
        How deep [m], and how hard they would push each other [N]: all springs together, in whatever
        direction each of them pushes.
    stays
        Whether they may go on overlapping: their bodies are of one tree of joints, such as links of
        a robot, or joints hold them as they are.
    """

    pair: int
    depth: float
    force: float
    stays: bool


class InitialOverlap:
    """Looks at the poses that a simulation begins with.

    Parameters
    ----------
    plant
        Finalized.
    model, bodies
        The contact model, and the plant's body for each of its bodies.
    policy
        "ease", "filter", "warn" or "raise"; see `ContactConfig.initial_overlap`.
    easing_time
        [s] in which "ease" parts bodies.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        *,
        policy: str = "ease",
        easing_time: float = 0.2,
    ) -> None:
        if policy not in POLICIES:
            known = ", ".join(POLICIES)
            raise ValueError(f"initial_overlap must be one of {known}, not {policy!r}")
        if not 0 < easing_time < math.inf:
            raise ValueError(f"easing_time must be a time [s] > 0, not {easing_time}")
        self._model, self._bodies = model, tuple(bodies)
        self._inside = CommonInside(model)
        self._plant = plant
        self._policy = policy
        self._easing_time = easing_time
        group_of = joint_trees(plant)
        rows = zip(model.geometry_bodies, model.geometries, strict=True)
        whole = WholeBodies(plant, ((bodies[row], each.mesh, each.X_BG) for row, each in rows))
        self._within, self._deep, self._heavy = [], [], []
        for pair in model.pairs:
            a, b = (bodies[model.geometry_bodies[side]] for side in (pair.a, pair.b))
            self._within.append(group_of[a] == group_of[b])
            sides = whole.of(a), whole.of(b)
            self._deep.append(_DEEP * min(side.diagonal for side in sides))
            weight = min(side.weight for side in sides)
            self._heavy.append(_HEAVY * weight if math.isfinite(weight) else 0.0)

    def find(self, forces: Forces, X_WB: Floats, q: Floats | None = None) -> list[Overlap]:
        """Return the pairs that overlap, the deepest first.

        X_WB (nb, 4, 4) and q (nq,) are the poses and the plant's positions; without the latter
        nobody looks at what joints allow.
        """
        contacts = forces.contacts
        inside = self._inside.find(X_WB)
        joints = None
        if q is not None and len(contacts.pair):
            joints = JointHold(self._plant, self._model, self._bodies, q, contacts)
        overlaps = []
        for pair in map(int, {*np.unique(contacts.pair), *inside}):
            rows = contacts.pair == pair
            standoff = self._model.pairs[pair].web.standoff
            depth = float(contacts.deformation[rows].max(initial=standoff) - standoff)
            # What crosses another in the middle is pushed both ways at once, and no less deep in.
            force = float(contacts.normal_force[rows].sum())
            ball = inside.get(pair, 0.0)
            pushed = depth > self._deep[pair] and force > self._heavy[pair]
            if pushed or ball > max(depth, self._deep[pair]):
                held = joints is not None and joints.holds_against_push(pair)
                stays = self._within[pair] or held
                overlaps.append(Overlap(pair, max(depth, ball), force, stays))
        return sorted(overlaps, key=lambda overlap: (-overlap.depth, overlap.pair))

    def begin(
        self,
        state: ContactState,
        push: Callable[[], Forces],
        time: float,
        X_WB: Floats,
        q: Floats | None = None,
    ) -> ContactState:
        """Return the state to begin with, after telling what overlaps.

        A simulation that goes on keeps its state, and bodies that are apart keep theirs. `push`
        gives the forces at the start; X_WB and q as in `find`. Raises RuntimeError where there is
        something, and the policy says so.
        """
        goes_on = state.forces is not None and state.time <= time
        overlaps = [] if goes_on else self.find(push(), X_WB, q)
        if not overlaps:
            return state
        if self._policy == "raise":
            raise RuntimeError(self._tell(overlaps, "start apart, or set initial_overlap"))
        if self._policy == "warn":
            _warn(
                self._tell(
                    overlaps,
                    "they will be flung apart; start apart, or set "
                    "initial_overlap to ease or filter",
                )
            )
            return state
        depths = np.zeros(len(self._model.pairs))
        filtered = [each for each in overlaps if self._policy == "filter" or each.stays]
        eased = [each for each in overlaps if each not in filtered]
        if filtered:
            depths[[each.pair for each in filtered]] = math.inf
            _warn(
                self._tell(
                    filtered,
                    "they pass through each other from now on, as must links of a robot that "
                    "overlap at rest, and what its joints hold in place; start apart to let them "
                    "touch",
                )
            )
        if eased:
            depths[[each.pair for each in eased]] = [each.depth for each in eased]
            _warn(
                self._tell(
                    eased,
                    f"they are parted gently within {self._easing_time:g} s "
                    "(easing_time); start apart, or set initial_overlap",
                )
            )
        return self._model.eased_state(depths, time, self._easing_time)

    def _tell(self, overlaps: Sequence[Overlap], mend: str) -> str:
        listed = []
        for each in overlaps[:_LISTED]:
            a, b = self._model.pair_names(each.pair)
            listed.append(f"{a} and {b} by {1000 * each.depth:.3g} mm ({each.force:.2g} N)")
        more = len(overlaps) - len(listed)
        rest = f", and {more} more pairs" if more else ""
        return f"overlap at the start: {', '.join(listed)}{rest}; {mend}"


def _warn(message: str) -> None:
    warnings.warn(message, RuntimeWarning, stacklevel=2)
