"""StepWatch: says, once, where an implicit step was not solved or lands elsewhere."""

from __future__ import annotations

import warnings
from dataclasses import replace

from systems.diagnostics.contact_watch import Reported
from systems.step.solved_step import SolvedStep

# Of a solution that is not converged, and far enough off to matter.
_UNSOLVED = 2
_RESIDUAL = 1e-3
# [m/s, rad/s] Velocities that differ by more are worth a word.
_MISMATCH = 1e-4


class StepWatch:
    """Checks every implicit step."""

    def check(self, reported: Reported, step: SolvedStep) -> Reported:
        """Warn of what is new; return what has been reported then."""
        solution = step.solution
        if solution.status >= _UNSOLVED and solution.residual > _RESIDUAL:
            if not reported.failed_steps:
                warnings.warn(
                    f"the contact forces of the step at {solution.start_time:.6g} s balance only "
                    f"to {solution.residual:.1e} of what drives it; if the motion looks wrong "
                    "there, take shorter steps (later ones are counted without a word)",
                    RuntimeWarning,
                    stacklevel=2,
                )
            reported = replace(reported, failed_steps=reported.failed_steps + 1)
        if step.mismatch > _MISMATCH and not reported.mismatched:
            warnings.warn(
                f"the step at {solution.start_time:.6g} s lands {step.mismatch:.1e} (m/s or rad/s) "
                "from where contact was solved for: a joint limit, constraint or controller and "
                "contact did not come to agree; take shorter steps",
                RuntimeWarning,
                stacklevel=2,
            )
            reported = replace(reported, mismatched=True)
        return reported
