"""InitialOverlap: what to do about bodies that overlap when a simulation begins."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import ContactModel, ContactState, Forces
from systems.plant.whole_bodies import WholeBodies

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
        How deep [m], and how hard they would push each other [N].
    within
        Whether their bodies are of one tree of joints, such as links of a robot.
    """

    pair: int
    depth: float
    force: float
    within: bool


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
        self._model = model
        self._policy = policy
        self._easing_time = easing_time
        group_of = _assemblies(plant)
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

    def find(self, forces: Forces) -> list[Overlap]:
        """Return the pairs that overlap, the deepest first."""
        contacts = forces.contacts
        overlaps = []
        for pair in np.unique(contacts.pair):
            rows = contacts.pair == pair
            depth = float(contacts.deformation[rows].max() - self._model.pairs[pair].web.standoff)
            pushes = contacts.normal_force[rows, None] * contacts.normal_F[rows]
            force = float(np.linalg.norm(pushes.sum(axis=0)))
            if depth > self._deep[pair] and force > self._heavy[pair]:
                overlaps.append(Overlap(int(pair), depth, force, self._within[pair]))
        return sorted(overlaps, key=lambda overlap: -overlap.depth)

    def begin(self, state: ContactState, push: Callable[[], Forces], time: float) -> ContactState:
        """Return the state to begin with, after telling what overlaps.

        A simulation that goes on keeps its state, and bodies that are apart keep theirs. `push`
        gives the forces at the start. Raises RuntimeError where there is something, and the policy
        says so.
        """
        goes_on = state.forces is not None and state.time <= time
        overlaps = [] if goes_on else self.find(push())
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
        filtered = [each for each in overlaps if self._policy == "filter" or each.within]
        eased = [each for each in overlaps if each not in filtered]
        if filtered:
            depths[[each.pair for each in filtered]] = math.inf
            _warn(
                self._tell(
                    filtered,
                    "they pass through each other from now on, as links of "
                    "a robot that overlap at rest must; start apart to let them touch",
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


def _assemblies(plant: MultibodyPlant) -> list[int]:
    """Return a number for each body, equal for bodies of one tree of joints.

    The world is an assembly of its own: what stands on it is not part of it. Nor are free bodies of
    one model instance, which may be all there are.
    """
    world = plant.world_body().index()
    leader = list(range(plant.num_bodies()))

    def join(a: int, b: int) -> None:
        old, new = leader[a], leader[b]
        leader[:] = [new if each == old else each for each in leader]

    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        ends = joint.parent_body().index(), joint.child_body().index()
        if world not in ends:
            join(*map(int, ends))
    return leader


def _warn(message: str) -> None:
    warnings.warn(message, RuntimeWarning, stacklevel=2)
