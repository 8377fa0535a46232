"""What Drake leaves out of a plant without saying so, by name."""

from __future__ import annotations

import warnings

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointIndex

_LISTED = 6  # names; an arm has as many


def warn_of_silent_losses(plant: MultibodyPlant) -> None:
    """Warn of joint limits that a continuous plant ignores, and of what fails only at run time.

    Constraints and couplers of a continuous plant are not built in: Drake raises when it first
    needs them, of which this tells beforehand.
    """
    if plant.time_step() > 0:
        return
    limited = [
        joint.name()
        for joint in (plant.get_joint(JointIndex(int(i))) for i in plant.GetJointIndices())
        if np.isfinite(joint.position_lower_limits()).any()
        or np.isfinite(joint.position_upper_limits()).any()
    ]
    lost = []
    if limited:
        more = len(limited) - _LISTED
        names = ", ".join(limited[:_LISTED]) + (f" and {more} more" if more > 0 else "")
        lost.append(f"the limits of {names}")
    if count := plant.num_constraints():
        lost.append(f"its {count} constraint{'s' if count > 1 else ''} (couplers, welds, balls)")
    if lost:
        warnings.warn(
            f"in a continuous plant (time_step = 0) Drake leaves out {' and '.join(lost)}: bodies "
            "will move past them; give the plant a time step, such as 2e-3 s, for which contact is "
            "solved with the step",
            UserWarning,
            stacklevel=3,
        )
