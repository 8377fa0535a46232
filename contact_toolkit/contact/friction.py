"""Friction: what limits and what holds the tangential force between two bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Friction:
    """Tangential springs and dampers within the friction cone.

    F_t = −(k_t s + β v_t), scaled back to ‖F_t‖ ≤ μ F_n; s is the stretch since the contact stuck,
    v_t the slip velocity. While it slips, the spring's anchor is dragged so that the stretch stays
    on the cone; a contact that is held never creeps.

    Parameters
    ----------
    static
        Coefficient at which a contact at rest begins to slide.
    dynamic
        Coefficient while it slides; the static one unless given.
    stiffness_ratio
        k_t over the normal spring constant: 2/3 to 1 for solids (Mindlin's ratio of the two,
        2 (1 − ν)/(2 − ν), for Poisson's ratios ν of 0.5 to 0); 0 for media that only resist motion.
    damping
        β over the normal spring constant [s]. Unless given, tangential motion is damped as normal
        motion is: β = 3/2 α κ times the elastic normal force, κ the stiffness ratio.

    Raises
    ------
    ValueError
        Naming the parameter out of range.

    Examples
    --------
    >>> from contact_toolkit import Friction
    >>> Friction(static=0.6, dynamic=0.5).dynamic_coefficient
    0.5
    >>> Friction.combined_coefficient(0.5, 1.0)  # 2 a b/(a + b)
    0.6666666666666666
    """

    static: float = 0.0
    dynamic: float | None = None
    stiffness_ratio: float = 2 / 3
    damping: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.static) and self.static >= 0):
            raise ValueError(f"static must be finite and not negative, not {self.static}")
        if self.dynamic is not None and not 0 <= self.dynamic <= self.static:
            raise ValueError(
                f"dynamic must be between 0 and the static coefficient {self.static}, not "
                f"{self.dynamic}"
            )
        if self.stiffness_ratio != 0 and not 2 / 3 <= self.stiffness_ratio <= 1:
            raise ValueError(
                f"stiffness_ratio must be 0 or between 2/3 and 1, not {self.stiffness_ratio}"
            )
        if self.damping is not None and not (math.isfinite(self.damping) and self.damping >= 0):
            raise ValueError(f"damping must be finite and not negative, not {self.damping}")

    @property
    def dynamic_coefficient(self) -> float:
        """The dynamic coefficient, given or taken over from the static one."""
        return self.static if self.dynamic is None else self.dynamic

    @staticmethod
    def combined_coefficient(a: float, b: float) -> float:
        """Return the coefficient between two surfaces as Drake does: 2 a b/(a + b)."""
        if not (a >= 0 and b >= 0):
            raise ValueError(f"coefficients must not be negative: {a} and {b}")
        return 2 * a * b / (a + b) if a + b > 0 else 0.0
