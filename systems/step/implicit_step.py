"""ImplicitStep: contact forces of a discrete plant, solved together with its step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import ContactModel, ContactState, StepSolution, StepSolver
from systems.plant.pairs import GeometryPair
from systems.step.linearized_step import LinearizedStep, StepSlopes
from systems.step.plant_answer import PlantAnswer, PlantAnswers, outer_forces
from systems.step.plant_trees import PlantTrees
from systems.step.plant_twin import PlantTwin, TwinAtState
from systems.step.solved_step import SolvedStep

Floats = NDArray[np.float64]

# A plant step lands this close to where the solver put it, relative to the change of velocity.
_TOLERANCE = 1e-6
# Solves in which contact and the plant's own limits and constraints come to agree.
_ROUNDS = 8


class _Contact(NamedTuple):
    """Contact solved under an answer: velocities aimed at and generalized forces, (nv,)."""

    solution: StepSolution
    aimed: Floats
    forces: Floats


class ImplicitStep:
    """Solves backward Euler in the contact forces of a discrete plant.

        A (v⁺ − v_free) = h Jᵀ F(q₀ + h N v⁺, v⁺)

    The forces go to the plant's ordinary port, and its own update then lands on v⁺: v_free is where
    that update goes without contact, asked of a `PlantTwin`, and A what it answers forces with: the
    mass matrix, joint damping and the gains of controllers. Where limits or constraints of the
    plant join in, A is taken from the twin, and solving is repeated until the twin agrees. Once it
    has agreed it is asked but once a step, under the forces of the last one, or not at all where
    v_free has a closed form, as long as the plant lands where it should, far from its limits.

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
        self._floats = not len(trees.rest)
        self._answers = PlantAnswers(self._twin, trees.rest)
        self._gravity = self._known_gravity() if self._answers.affine and self._floats else None

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
        answer = self._answers.begin(twin, x, inputs, last)
        free = float(np.abs(answer.v_plain - v).max())
        v_next = v
        if last is not None and np.abs(last.change).max() <= free:
            v_next = v + last.change  # no impact: it goes on as in the last step
        X_WB, jacobian = self._X_WB, self._no_jacobian
        if self._links:
            X_WB, jacobian = X_WB.copy(), np.zeros(jacobian.shape)
            twin.kinematics_after(self._step, v_next, self._links, X_WB, jacobian)

        def under(answer: PlantAnswer) -> _Contact:
            return self._solve(state, time, x, answer, X_WB, jacobian, v_next)

        contact = under(answer)
        if not self._answers.is_certain(answer, q, contact.aimed, inputs):
            return self._agree(twin, x, inputs, answer, contact, under)
        change = contact.aimed - v
        allowed = _TOLERANCE * (free + float(np.abs(change).max()))
        solution, aimed, forces = contact
        return SolvedStep(
            solution, aimed, change, forces, 0.0, allowed, 1, answer.stiffening, trusted=True
        )

    def _agree(
        self,
        twin: TwinAtState,
        x: Floats,
        inputs: Mapping[str, object],
        answer: PlantAnswer,
        contact: _Contact,
        under: Callable[[PlantAnswer], _Contact],
    ) -> SolvedStep:
        """Solve contact `under` other answers until the plant goes where it aims."""
        q, v, outer = x[: self._nq], x[self._nq :], outer_forces(inputs, self._nv)
        free = np.abs(answer.v_plain - v).max()
        best, before = (np.inf, contact), np.inf
        for round_ in range(1, _ROUNDS + 1):
            reached = twin.reached(outer + contact.forces)
            mismatch = float(np.abs(reached - contact.aimed).max())
            allowed = _TOLERANCE * float(free + np.abs(contact.aimed - v).max())
            agreed = mismatch <= allowed and self._answers.is_complete(answer, contact.forces)
            if agreed or mismatch < best[0]:
                best = mismatch, contact
            # What floats has no other answer.
            if agreed or self._floats or round_ == _ROUNDS:
                break
            answer = self._answers.learn(
                twin, answer, outer, contact.forces, reached, by_turns=mismatch > before / 2
            )
            contact, before = under(answer), mismatch
        mismatch, (solution, aimed, forces) = best
        trusted = agreed and self._answers.is_proved(answer, q, aimed, forces, inputs)
        return SolvedStep(
            solution,
            aimed,
            aimed - v,
            forces,
            mismatch,
            allowed,
            round_,
            answer.stiffening,
            trusted,
        )

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

    def _solve(
        self,
        state: ContactState,
        time: float,
        x: Floats,
        answer: PlantAnswer,
        X_WB: Floats,
        jacobian: Floats,
        v_next: Floats,
    ) -> _Contact:
        q, v = x[: self._nq], x[self._nq :]
        v_plain, inertia, order = answer.v_plain, answer.inertia, self._order
        if order is None:
            solution = self._solver.solve(
                state, time, self._step, q, v, v_plain, X_WB, inertia, jacobian, v_next
            )
            return _Contact(solution, solution.v, solution.generalized_forces)
        if not self._floats:
            inertia, jacobian = inertia[np.ix_(order, order)], jacobian[:, :, order].copy()
        v, v_plain, v_next = v[order], v_plain[order], v_next[order]
        solution = self._solver.solve(
            state, time, self._step, q, v, v_plain, X_WB, inertia, jacobian, v_next
        )
        aimed, forces = np.empty_like(v), np.empty_like(v)
        aimed[order], forces[order] = solution.v, solution.generalized_forces
        return _Contact(solution, aimed, forces)
