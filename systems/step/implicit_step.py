"""ImplicitStep: contact forces of a discrete plant, solved together with its step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointActuatorIndex

from contact_toolkit import ContactModel, ContactState, StepSolution, StepSolver
from systems.plant.pairs import GeometryPair
from systems.step.free_motion import FORCES, FreeMotion
from systems.step.linearized_step import LinearizedStep, StepSlopes
from systems.step.plant_trees import PlantTrees
from systems.step.plant_twin import PlantTwin, TwinAtState
from systems.step.step_limits import StepLimits

Floats = NDArray[np.float64]

# A plant step lands this close to where the solver put it, relative to the change of velocity.
_TOLERANCE = 1e-6
# Solves in which contact and the plant's own limits and constraints come to agree.
_ROUNDS = 8
# [-] Of the free response: what a force does to velocities that a constraint holds fast.
_RIGID = 1e-10
_NOTHING = np.zeros((0, 0))


class SolvedStep(NamedTuple):
    """A step of the plant under contact.

    Attributes
    ----------
    solution
        As the native solver found it; velocities in its own order.
    velocities
        (nv,) that contact was solved for.
    change
        (nv,) of the velocities in the step.
    generalized_forces
        (nv,) of contact, over the whole step.
    mismatch
        Largest difference [m/s, rad/s] between the velocities that the plant reaches and those that
        contact was solved for; 0 where the plant answers forces as A says, and was not asked.
    allowed
        Mismatch up to which the two count as agreed.
    rounds
        Solves it took contact and the plant's limits and constraints to agree.
    stiffening
        What the plant's limits and constraints were found to add to A, on the velocities that are
        not those of floating bodies; None where they add nothing. Good to begin the next step with.
    trusted
        Whether the plant's answer to contact forces was seen to be A, in this step or before, far
        from all limits.
    """

    solution: StepSolution
    velocities: Floats
    change: Floats
    generalized_forces: Floats
    mismatch: float
    allowed: float
    rounds: int
    stiffening: Floats | None = None
    trusted: bool = False

    def leads_to(self, v: Floats) -> bool:
        """Whether the plant went where its answer to forces, trusted, led to: velocities (nv,)."""
        return self.trusted and bool(np.abs(v - self.velocities).max() <= self.allowed)

    @property
    def statistics(self) -> Floats:
        """(5,) Newton iterations, force evaluations, islands, status, rounds."""
        found = self.solution
        return np.array(
            [found.iterations, found.evaluations, found.islands, found.status, self.rounds], float
        )


class _Begun(NamedTuple):
    """A step before contact is solved for.

    Attributes
    ----------
    v_plain
        (nv,) where it leads without contact.
    reached
        (nv,) where the plant was seen to go, under likely forces or without.
    inertia, stiffening
        A, and what of it limits and constraints were found to add.
    trusted
        Whether the plant is known to answer as A says.
    """

    v_plain: Floats
    reached: Floats
    inertia: Floats
    stiffening: Floats | None
    trusted: bool


class ImplicitStep:
    """Solves backward Euler in the contact forces of a discrete plant.

        A (v⁺ − v_free) = h Jᵀ F(q₀ + h N v⁺, v⁺)

    The forces go to the plant's ordinary port, and its own update then lands on v⁺: v_free is where
    that update goes without contact, asked of a `PlantTwin`, and A what it answers forces with: the
    mass matrix, joint damping and the gains of controllers. Where limits or constraints of the
    plant join in, A is taken from the twin, and solving is repeated until the twin agrees. Once it
    has agreed it is asked but once a step, under the forces of the last one, as long as the plant
    lands where it should, far from its limits.

    Parameters
    ----------
    plant
        Finalized and discrete.
    scene_graph
        Its scene graph.
    model, bodies
        The contact model, and the plant's body for each of its bodies.
    pairs
        The geometries that the model stands for.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        pairs: Sequence[GeometryPair],
    ) -> None:
        self._twin = PlantTwin(plant, scene_graph, pairs)
        self._model, self._bodies = model, tuple(bodies)
        self._slopes: StepSlopes | None = None  # when the first is asked for
        self._step = plant.time_step()
        self._nq, self._nv = plant.num_positions(), plant.num_velocities()
        trees = PlantTrees(self._twin.plant, bodies, self._twin.touching)
        self._jointed = trees.jointed
        links = {row: self._twin.plant.get_body(index) for row, index in trees.jointed.items()}
        self._links = [(row, body, body.body_frame()) for row, body in links.items()]
        self._X_WB = trees.X_WB
        self._no_jacobian = np.zeros((len(bodies), 6, self._nv if self._jointed else 0))
        self._solver = StepSolver(
            model,
            num_positions=self._nq,
            num_velocities=self._nv,
            v_start=trees.v_start,
            nv=trees.nv,
            q_start=trees.q_start,
            inertia_R=trees.inertia_R,
            tree=trees.tree,
            X_RB=trees.X_RB,
        )
        self._order = trees.order
        self._dofs = trees.rest
        self._floats = not len(trees.rest)
        self._own = _implicit_terms(plant, self._step)
        self._block = np.ix_(trees.rest, trees.rest)
        self._constrained = plant.num_constraints() > 0
        self._limits = StepLimits(plant)
        # Forces move such a plant as A says, whatever else acts on it.
        self._affine = not (self._constrained or self._twin.touching or self._limits.bend)
        self._gravity = self._known_gravity() if self._affine and self._floats else None
        self._free = self._known_free_motion()

    def solve(
        self,
        time: float,
        x: Floats,
        inputs: Mapping[str, object],
        state: ContactState,
        last: SolvedStep | None = None,
    ) -> SolvedStep:
        """Solve the step from state x (nq + nv) at `time` [s].

        Parameters
        ----------
        inputs
            Values at the plant's other input ports, by name.
        state
            Of contact, at the start of the step.
        last
            The step before, if there was one.
        """
        q, v = x[: self._nq], x[self._nq :]
        if self._gravity is not None and not inputs:
            solution = self._solver.solve_under_gravity(
                state, time, self._step, q, v, self._gravity, self._X_WB
            )
            forces = solution.generalized_forces
            return SolvedStep(solution, solution.v, solution.v - v, forces, 0.0, 0.0, 1)
        twin = self._twin.at(x, inputs)
        given = inputs.get(FORCES)
        outer = np.zeros(self._nv) if given is None else np.asarray(given)
        begun = self._begin(twin, v, outer, inputs, last)
        v_plain, reached, inertia, stiffening, trusted = begun
        own = inertia if stiffening is None else inertia - stiffening
        free = np.abs(v_plain - v).max()
        v_next = v
        if last is not None and np.abs(last.change).max() <= free:
            v_next = v + last.change  # no impact: it goes on as in the last step
        X_WB, jacobian = self._X_WB, self._no_jacobian
        if self._links:
            X_WB, jacobian = X_WB.copy(), np.zeros(jacobian.shape)
            twin.kinematics_after(self._step, v_next, self._links, X_WB, jacobian)
        mismatch, before = 0.0, np.inf
        best: tuple[float, tuple[StepSolution, Floats, Floats]] | None = None
        for round_ in range(1, _ROUNDS + 1):
            solved = self._solve(state, time, q, v, v_plain, X_WB, inertia, jacobian, v_next)
            solution, aimed, forces = solved
            led = np.abs(aimed - v).max()
            allowed = _TOLERANCE * float(led + free)
            far = self._affine or self._limits.are_far(
                q, np.array([reached, aimed]), self._step, inputs
            )
            if self._affine or (trusted and far):
                mismatch, trusted = 0.0, True
                break
            reached = twin.reached(outer + forces)
            mismatch = float(np.abs(reached - aimed).max())
            agreed, bears = mismatch <= allowed, bool(forces[self._dofs].any())
            known = stiffening is not None or not (self._constrained and bears)
            seen = bears or self._free is not None
            trusted = agreed and known and far and seen and not self._twin.touching
            if (agreed and known) or (self._floats and mismatch > before / 2):
                break
            if best is None or mismatch < best[0]:
                best = mismatch, solved
            if round_ == _ROUNDS:
                mismatch, (solution, aimed, forces) = best
            elif not self._floats:
                found = self._response(twin, outer + forces, reached, own)
                # A limit that is reached by turns is reached in part.
                inertia = self._between(inertia, found) if mismatch > before / 2 else found
                stiffening = inertia - own
                v_plain = self._without(forces, reached, inertia, v_plain)
            before = mismatch
        return SolvedStep(
            solution, aimed, aimed - v, forces, mismatch, allowed, round_, stiffening, trusted
        )

    def _begin(
        self,
        twin: TwinAtState,
        v: Floats,
        outer: Floats,
        inputs: Mapping[str, object],
        last: SolvedStep | None,
    ) -> _Begun:
        """Return what is known of a step before contact is solved for."""
        inertia = _NOTHING if self._floats else twin.mass_matrix() + self._own
        trusted = last is None or last.leads_to(v)
        if trusted and self._free is not None and self._free.knows(inputs):
            v_free = twin.free_motion(self._free, inputs, inertia)
            return _Begun(v_free, v_free, inertia, None, True)
        if last is None:
            v_free = twin.reached(outer)
            return _Begun(v_free, v_free, inertia, None, False)
        if last.stiffening is not None:
            inertia = inertia + last.stiffening
        if not trusted:
            v_free = twin.reached(outer)
            return _Begun(v_free, v_free, inertia, last.stiffening, False)
        likely = np.zeros(self._nv)
        likely[self._dofs] = last.generalized_forces[self._dofs]
        reached = twin.reached(outer + likely)
        v_plain = self._without(likely, reached, inertia, reached)
        return _Begun(v_plain, reached, inertia, last.stiffening, True)

    def _without(self, forces: Floats, reached: Floats, inertia: Floats, v_plain: Floats) -> Floats:
        """Return v_plain, with the velocities that are not of floating bodies as without forces."""
        dofs, v_plain = self._dofs, v_plain.copy()
        response = self._step * np.linalg.solve(inertia[self._block], forces[dofs])
        v_plain[dofs] = reached[dofs] - response
        return v_plain

    def linearize(
        self,
        x: Floats,
        inputs: Mapping[str, object],
        state: ContactState,
        step: SolvedStep,
        port: str,
    ) -> LinearizedStep:
        """Linearize a step that was solved, by x and by the values at one of the input ports."""
        if self._slopes is None:
            self._slopes = StepSlopes(
                self._twin, self._model, self._bodies, self._jointed, self._X_WB, self._step
            )
        return self._slopes.at(x, inputs, state, step.velocities, port)

    def _known_gravity(self) -> Floats | None:
        """Return the gravity under which the native free motion is the plant's; None: it is not."""
        if self._order is not None:
            return None
        gravity = self._twin.plant.gravity_field().gravity_vector()
        x = self._twin.plant.GetPositionsAndVelocities(self._twin.default_context())
        q, v = x[: self._nq], np.linspace(0.5, 1.5, self._nv)
        expected = self._twin.at(np.concatenate([q, v]), {}).reached(np.zeros(self._nv))
        found = self._solver.free_motion(q, v, self._step, gravity)
        return gravity if np.allclose(found, expected, rtol=1e-12, atol=1e-13) else None

    def _known_free_motion(self) -> FreeMotion | None:
        """Return the closed form of the free motion; None: the plant's is another."""
        if self._constrained or self._twin.touching:
            return None
        twin = self._twin.plant
        free = FreeMotion(twin)
        x = twin.GetPositionsAndVelocities(self._twin.default_context())
        x[: self._nq] = self._limits.amid(x[: self._nq])
        x[self._nq :] = np.linspace(0.1, 0.3, self._nv)
        inputs = free.some_inputs(x)
        at = self._twin.apart(x, inputs)
        expected = at.reached(inputs[FORCES])
        A = at.mass_matrix() + self._own
        found = at.free_motion(free, inputs, A)
        ends = np.array([expected, found])
        if not self._limits.are_far(x[: self._nq], ends, self._step, inputs):
            return None
        return free if np.allclose(found, expected, rtol=1e-9, atol=1e-11) else None

    def _solve(
        self,
        state: ContactState,
        time: float,
        q: Floats,
        v: Floats,
        v_free: Floats,
        X_WB: Floats,
        inertia: Floats,
        jacobian: Floats,
        v_next: Floats,
    ) -> tuple[StepSolution, Floats, Floats]:
        """Return the solution, its velocities and its generalized forces (nv,)."""
        order = self._order
        if order is None:
            solution = self._solver.solve(
                state, time, self._step, q, v, v_free, X_WB, inertia, jacobian, v_next
            )
            return solution, solution.v, solution.generalized_forces
        if not self._floats:
            inertia, jacobian = inertia[np.ix_(order, order)], jacobian[:, :, order].copy()
        solution = self._solver.solve(
            state,
            time,
            self._step,
            q,
            v[order],
            v_free[order],
            X_WB,
            inertia,
            jacobian,
            v_next[order],
        )
        reached, forces = np.empty_like(v), np.empty_like(v)
        reached[order], forces[order] = solution.v, solution.generalized_forces
        return solution, reached, forces

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


def _implicit_terms(plant: MultibodyPlant, step: float) -> Floats:
    """Return (nv, nv) what joint damping and controllers add to the mass matrix over a step."""
    own = np.zeros(plant.num_velocities())
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities():
            start = joint.velocity_start()
            own[start : start + joint.num_velocities()] += step * joint.default_damping_vector()
    for i in range(plant.num_actuators()):
        actuator = plant.get_joint_actuator(JointActuatorIndex(i))
        if actuator.has_controller():
            gains = actuator.get_controller_gains()
            own[actuator.joint().velocity_start()] += step * gains.d + step**2 * gains.p
    return np.diag(own)
