"""PlantAnswers: where a plant goes in a step without contact, and how forces change that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from systems.step.controllers import Controllers, controllers_of
from systems.step.free_motion import FORCES, FreeMotion
from systems.step.plant_twin import PlantTwin, TwinAtState
from systems.step.solved_step import SolvedStep
from systems.step.step_limits import StepLimits

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# [-] Of the free response: what a force does to velocities that a constraint holds fast.
_RIGID = 1e-10
_NOTHING = np.zeros((0, 0))


class PlantAnswer(NamedTuple):
    """How a plant is taken to answer forces f in a step: A (v⁺ − v_plain) = h f.

    Attributes
    ----------
    v_plain
        (nv,) where it leads without contact.
    reached
        (nv,) where the plant was seen to go, under likely forces or without.
    inertia, stiffening
        A, and what of it limits and constraints were found to add (None: nothing).
    trusted
        Whether the plant is known to answer so, far from its limits.
    """

    v_plain: Floats
    reached: Floats
    inertia: Floats
    stiffening: Floats | None
    trusted: bool


class PlantAnswers:
    """Finds them out: in closed form, from the last step, or by asking a plant's copy.

    Parameters
    ----------
    twin
        The copy.
    dofs
        Velocities that are not of bodies which float by themselves.
    """

    def __init__(self, twin: PlantTwin, dofs: Integers) -> None:
        plant, controllers = twin.plant, controllers_of(twin.plant)
        self._twin, self._dofs, self._block = twin, dofs, np.ix_(dofs, dofs)
        self._nq, self._nv, self._step = (
            plant.num_positions(), plant.num_velocities(), plant.time_step(),
        )  # fmt: skip
        self._own = _implicit_terms(plant, controllers)
        self._constrained = plant.num_constraints() > 0
        self._limits = StepLimits(plant, controllers)
        self.affine = not (self._constrained or twin.touching or self._limits.bend)
        """Whether forces move it as A says, whatever else acts on it."""
        self._free = self._known_free_motion(controllers)

    def begin(
        self, twin: TwinAtState, x: Floats, inputs: Mapping[str, object], last: SolvedStep | None
    ) -> PlantAnswer:
        """Return what is known of a step from state x (nq + nv), before contact is solved for."""
        inertia = twin.mass_matrix() + self._own if len(self._dofs) else _NOTHING
        trusted = last is None or last.leads_to(x[self._nq :])
        if trusted and self._free is not None and self._free.knows(inputs):
            v_free = twin.free_motion(self._free, inputs, inertia)
            return PlantAnswer(v_free, v_free, inertia, None, True)
        outer = outer_forces(inputs, self._nv)
        if last is None:
            v_free = twin.reached(outer)
            return PlantAnswer(v_free, v_free, inertia, None, False)
        if last.stiffening is not None:
            inertia = inertia + last.stiffening
        if not trusted:
            v_free = twin.reached(outer)
            return PlantAnswer(v_free, v_free, inertia, last.stiffening, False)
        likely = np.zeros(self._nv)
        likely[self._dofs] = last.generalized_forces[self._dofs]
        reached = twin.reached(outer + likely)
        v_plain = self._without(likely, reached, inertia, reached)
        return PlantAnswer(v_plain, reached, inertia, last.stiffening, True)

    def is_certain(
        self, answer: PlantAnswer, q: Floats, aimed: Floats, inputs: Mapping[str, object]
    ) -> bool:
        """Whether the plant need not be asked if it goes to the velocities `aimed` (nv,)."""
        return self.affine or (answer.trusted and self._are_far(q, answer.reached, aimed, inputs))

    def is_complete(self, answer: PlantAnswer, forces: Floats) -> bool:
        """Whether nothing is missing in A for contact forces (nv,) that it was seen to hold for."""
        return answer.stiffening is not None or not (self._constrained and self._bears(forces))

    def is_proved(
        self,
        answer: PlantAnswer,
        q: Floats,
        aimed: Floats,
        forces: Floats,
        inputs: Mapping[str, object],
    ) -> bool:
        """Whether a plant that went to `aimed` under contact forces (nv,) may be trusted to."""
        seen = self._bears(forces) or self._free is not None
        return (
            seen
            and not self._twin.touching
            and self.is_complete(answer, forces)
            and self._are_far(q, aimed, aimed, inputs)
        )

    def learn(
        self,
        twin: TwinAtState,
        answer: PlantAnswer,
        outer: Floats,
        forces: Floats,
        reached: Floats,
        *,
        by_turns: bool,
    ) -> PlantAnswer:
        """Return the answer about contact forces (nv,) under which the plant went to `reached`.

        `by_turns`: limits are reached in one round and left in the next; then they are taken to be
        reached in part.
        """
        own = answer.inertia
        if answer.stiffening is not None:
            own = own - answer.stiffening
        inertia = self._response(twin, outer + forces, reached, own)
        if by_turns:
            inertia = self._between(answer.inertia, inertia)
        v_plain = self._without(forces, reached, inertia, answer.v_plain)
        return PlantAnswer(v_plain, reached, inertia, inertia - own, False)

    def _bears(self, forces: Floats) -> bool:
        return bool(forces[self._dofs].any())

    def _are_far(self, q: Floats, one: Floats, other: Floats, inputs: Mapping[str, object]) -> bool:
        return self._limits.are_far(q, np.array([one, other]), self._step, inputs)

    def _without(self, forces: Floats, reached: Floats, inertia: Floats, v_plain: Floats) -> Floats:
        """Return v_plain, with the velocities that are not of floating bodies as without forces."""
        dofs, v_plain = self._dofs, v_plain.copy()
        response = self._step * np.linalg.solve(inertia[self._block], forces[dofs])
        v_plain[dofs] = reached[dofs] - response
        return v_plain

    def _between(self, one: Floats, other: Floats) -> Floats:
        """Return the A that answers forces by the mean of what these two do."""
        between = other.copy()
        answers = np.linalg.inv(one[self._block]) + np.linalg.inv(other[self._block])
        between[self._block] = 2 * np.linalg.inv(answers)
        return between

    def _response(
        self, twin: TwinAtState, forces: Floats, reached: Floats, inertia: Floats
    ) -> Floats:
        """Return A at these forces, by asking the twin; floating bodies keep theirs."""
        dofs = self._dofs
        response = np.zeros((len(dofs), len(dofs)))
        # Small beside what acts, yet far above rounding.
        size = 1e-4 * (np.abs(forces).max() + 1e-3)
        for column, dof in enumerate(dofs):
            pushed = forces.copy()
            pushed[dof] += size
            response[:, column] = (twin.reached(pushed) - reached)[dofs] / size
        values, vectors = np.linalg.eigh(response / 2 + response.T / 2)
        free = self._step / np.diag(inertia)[dofs].max()
        values = np.maximum(values, _RIGID * max(values.max(), free))
        after = inertia.copy()
        after[self._block] = self._step * (vectors / values) @ vectors.T
        return after

    def _known_free_motion(self, controllers: list[Controllers]) -> FreeMotion | None:
        """Return the closed form of the free motion; None: the plant's is another."""
        if self._constrained or self._twin.touching:
            return None
        free = FreeMotion(self._twin.plant, controllers)
        x = self._twin.plant.GetPositionsAndVelocities(self._twin.default_context())
        x[: self._nq] = self._limits.amid(x[: self._nq])
        x[self._nq :] = np.linspace(0.1, 0.3, self._nv)
        inputs = free.some_inputs(x)
        at = self._twin.apart(x, inputs)
        expected = at.reached(inputs[FORCES])
        found = at.free_motion(free, inputs, at.mass_matrix() + self._own)
        if not self._are_far(x[: self._nq], expected, found, inputs):
            return None
        return free if np.allclose(found, expected, rtol=1e-9, atol=1e-11) else None


def outer_forces(inputs: Mapping[str, object], nv: int) -> Floats:
    """Return the generalized forces (nv,) of others at a plant's inputs."""
    given = inputs.get(FORCES)
    return np.zeros(nv) if given is None else np.asarray(given)


def _implicit_terms(plant: MultibodyPlant, controllers: list[Controllers]) -> Floats:
    """Return (nv, nv) what joint damping and controllers add to the mass matrix over a step."""
    own, step = np.zeros(plant.num_velocities()), plant.time_step()
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities():
            start = joint.velocity_start()
            own[start : start + joint.num_velocities()] += step * joint.default_damping_vector()
    for each in controllers:
        np.add.at(own, each.v, step * each.d + step**2 * each.p)
    return np.diag(own)
