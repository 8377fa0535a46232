"""The contact law of one spring: a nonlinear damper and its closed forms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# 1 − e as a power series in D; below the limit its remainder is under 2e-18 of its value.
_SERIES_LIMIT = 0.02
_LOSS_SERIES = (
    0.0,
    2 / 3,
    -4 / 9,
    44 / 135,
    -104 / 405,
    40 / 189,
    -7648 / 42525,
    2848 / 18225,
    -31712 / 229635,
    23429344 / 189448875,
    -89072576 / 795685275,
)


@dataclass(frozen=True)
class NonlinearDamper:
    """F = k δⁿ (1 + 3/2 α δ̇): an elastic force with damping in proportion to it.

    Zero at zero deformation, so that contact begins without a jump. `k` belongs to one spring of a
    facet web [N/mⁿ] or, as a foundation stiffness, to the area web [Pa/mⁿ].

    Parameters
    ----------
    k
        Spring constant, positive.
    alpha
        Restitution slope α ≥ 0 [s/m]: e = 1 − α v for small impact velocities v. Drake's
        Hunt–Crossley dissipation is 3/2 α.
    n
        Exponent ≥ 1: 1 for polyhedra, 1.5 for Hertz contact.
    adhesion
        Let the damping pull when the bodies are torn apart (mud); otherwise F ≥ 0.
    settling, smallest
        Settling speed s ≥ 0 and smallest speed w > 0 [m/s]. The law as published (s = 0) damps the
        smallest motions next to nothing, so bodies at rest rock on for minutes. With them δ̇ counts
        in the damping for δ̇ + s δ̇/(w + abs(δ̇)) · s/(s + abs(δ̇)): 1 + s/w times as much where it is
        small, about as s does up to s, as itself where it is large. The restitution of impacts
        falls by less than 3/2 α s, and the less the faster they are.

    Raises
    ------
    ValueError
        Naming the parameter out of range.

    Notes
    -----
    Hunt and Crossley, "Coefficient of restitution interpreted as damping in vibroimpact",
    J. Appl. Mech. 42(2), 1975. With a = 3/2 α and D = a v, a body that hits at v leaves at e v,
    where D (1 + e) = ln((1 + D)/(1 − e D)), whatever its mass, k, n and number of equal springs.

    Examples
    --------
    >>> from contact_toolkit import NonlinearDamper
    >>> damper = NonlinearDamper(k=1e6, alpha=NonlinearDamper.alpha_for(0.5, 1.0))
    >>> round(damper.restitution(1.0), 12)
    0.5
    >>> round(damper.equilibrium(9.81), 12)  # [m] under 1 kg
    9.81e-06
    """

    k: float
    alpha: float = 0.0
    n: float = 1.0
    adhesion: bool = False
    settling: float = 0.0
    smallest: float = 1e-5

    def __post_init__(self) -> None:
        if not (math.isfinite(self.k) and self.k > 0):
            raise ValueError(f"k must be positive and finite, not {self.k}")
        if not (math.isfinite(self.alpha) and self.alpha >= 0):
            raise ValueError(f"alpha must be finite and not negative, not {self.alpha}")
        if not (math.isfinite(self.n) and self.n >= 1):
            raise ValueError(f"n must be at least 1 and finite, not {self.n}")
        if not (math.isfinite(self.settling) and self.settling >= 0):
            raise ValueError(f"settling must be finite and not negative, not {self.settling}")
        if not (math.isfinite(self.smallest) and self.smallest > 0):
            raise ValueError(f"smallest must be positive and finite, not {self.smallest}")

    def force(self, deformation: ArrayLike, rate: ArrayLike) -> Floats:
        """Force [N] at deformations [m] and rates of deformation [m/s], positive approaching."""
        delta = np.maximum(np.asarray(deformation, np.float64), 0.0)
        counted = np.asarray(rate, np.float64)
        if self.settling > 0:
            speed = np.abs(counted)
            share = self.settling / (self.settling + speed)
            counted = counted * (1 + self.settling * share / (self.smallest + speed))
        force = self.k * delta**self.n * (1 + 1.5 * self.alpha * counted)
        return np.asarray(force if self.adhesion else np.maximum(force, 0.0))

    def energy(self, deformation: ArrayLike) -> Floats:
        """Elastic energy [J] stored at deformations [m]."""
        delta = np.maximum(np.asarray(deformation, np.float64), 0.0)
        return np.asarray(self.k * delta ** (self.n + 1) / (self.n + 1))

    def restitution(self, velocity: float) -> float:
        """Coefficient of restitution e of an impact at `velocity` [m/s]; 1 at zero.

        With a settling speed s it is lower than this, by less than 3/2 α s.
        """
        _require_not_negative(velocity=velocity)
        return 1 - _loss(1.5 * self.alpha * velocity)

    @staticmethod
    def alpha_for(restitution: float, velocity: float) -> float:
        """Return the α [s/m] that gives a `restitution` in (0, 1] at `velocity` [m/s] > 0."""
        from scipy.optimize import brentq  # noqa: PLC0415  the package imports with numpy alone

        _require_positive(velocity=velocity)
        if not 0 < restitution <= 1:
            raise ValueError(
                f"restitution must be in (0, 1], not {restitution}: the law always returns some of "
                f"the velocity"
            )
        loss = 1 - restitution
        if loss == 0:
            return 0.0
        # The loss grows with D: it is below 2/3 D everywhere, and e D < 1.
        root = brentq(lambda D: _loss(D) / loss - 1, 1.5 * loss, 1 / restitution, xtol=1e-300)
        return float(root) / (1.5 * velocity)

    def peak_deformation(self, mass: float, velocity: float) -> float:
        """Largest deformation [m] of one spring hit by `mass` [kg] at `velocity` [m/s]."""
        _require_positive(mass=mass)
        _require_not_negative(velocity=velocity)
        a = 1.5 * self.alpha
        work = 0.5 * velocity**2 if a * velocity == 0 else _log_gap(a * velocity) / a**2
        return float(((self.n + 1) * mass / self.k * work) ** (1 / (self.n + 1)))

    def elastic_impact_time(self, mass: float, velocity: float) -> float:
        """Duration [s] of an impact without damping (α = 0): π √(m/k) for n = 1."""
        _require_positive(mass=mass, velocity=velocity)
        peak = ((self.n + 1) * mass * velocity**2 / (2 * self.k)) ** (1 / (self.n + 1))
        fraction = 1 / (self.n + 1)
        quarter = math.sqrt(math.pi) * math.gamma(1 + fraction) / math.gamma(0.5 + fraction)
        return float(2 * peak / velocity * quarter)

    def equilibrium(self, load: float) -> float:
        """Deformation [m] at which one spring carries `load` [N]."""
        _require_not_negative(load=load)
        return float((load / self.k) ** (1 / self.n))

    def damping_ratio(self, mass: float, load: float) -> float:
        """Damping ratio ζ of small motions of `mass` [kg] about equilibrium under `load` [N].

        With a settling speed, that of such as are fast next to it.
        """
        _require_positive(mass=mass, load=load)
        slope = self.n * load / self.equilibrium(load)
        return 1.5 * self.alpha * load / (2 * math.sqrt(slope * mass))


def _log_gap(x: float) -> float:
    """Return x − ln(1 + x), without cancellation at small x."""
    if abs(x) > 0.3:
        return x - math.log1p(x)
    # ln(1 + x) = 2 artanh(s): the linear terms drop out on paper.
    s = x / (2 + x)
    return x * s - 2 * sum(s**k / k for k in range(3, 24, 2))


def _loss(D: float) -> float:
    """Return 1 − e for D = 3/2 α v, to 1e-13 of its value however small D is."""
    if D < _SERIES_LIMIT:
        return float(np.polynomial.polynomial.polyval(D, _LOSS_SERIES))
    # y = e D. Beyond D = 700 the exponential underflows to y = 1, as it should.
    from scipy.special import lambertw  # noqa: PLC0415  the package imports with numpy alone

    y = 1 + float(lambertw(-(1 + D) * math.exp(-(1 + D))).real)
    if y < 1:
        # Near its branch point W loses digits; one Newton step on −ln(1 − y) − y = D − ln(1 + D).
        y -= (_log_gap(-y) - _log_gap(D)) * (1 - y) / y
    return 1 - y / D


def _require_positive(**values: float) -> None:
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be positive and finite, not {value}")


def _require_not_negative(**values: float) -> None:
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{name} must be finite and not negative, not {value}")
