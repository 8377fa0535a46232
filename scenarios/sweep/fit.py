"""Fit parameters to what was measured, and say how sure that is."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as student

from scenarios.format.errors import ScenarioError

CONFIDENCE = 0.95
_UNKNOWN = 1e-8  # of the largest singular value; below, the series do not determine parameters

Floats = NDArray[np.float64]


@dataclasses.dataclass
class FreeParameter:
    """A parameter to be found.

    Attributes
    ----------
    sets
        Keys of the scenario that take it, as `contact.alpha`.
    start
        Where the search begins; not 0 on a logarithmic scale.
    lower, upper
        Where it ends.
    logarithmic
        Whether it is searched by factors, as a stiffness of unknown magnitude is.
    step
        By how much it is changed to see what comes of it, relative to `start` (to the range, where
        that is 0): more than the integrator's noise, less than what bends the answer.
    """

    sets: list[str] = dataclasses.field(default_factory=list)
    start: float = 1.0
    lower: float = -math.inf
    upper: float = math.inf
    logarithmic: bool = False
    step: float = 1e-3

    def value(self, u: float) -> float:
        """Return the parameter from the number of order 1 that is searched for."""
        if not self.logarithmic:
            return float(self.start + self._span * u)
        try:
            return self.start * math.exp(u)
        except OverflowError:
            return math.inf

    def place(self, value: float) -> float:
        """Return the inverse of `value`."""
        if not self.logarithmic:
            return (value - self.start) / self._span
        ratio = value / self.start
        return math.log(ratio) if ratio > 0.0 else -math.inf

    def telling(self, value: float) -> float:
        """Return how wide an interval around a value may be that still says something of it.

        As wide as the value (or the start, if that is larger and the scale is not logarithmic), but
        less than all that is allowed.
        """
        size = abs(value) if self.logarithmic else max(abs(value), self._span)
        return min(size, self.upper - self.lower)

    def check(self, where: str) -> None:
        """Raise ScenarioError for what cannot be searched."""
        if not self.lower < self.start < self.upper:
            raise ScenarioError(f"{where}.start must lie between lower and upper")
        if self.logarithmic and not self.start > 0.0:
            raise ScenarioError(f"{where}.start must be positive on a logarithmic scale")
        if not 0.0 < self.step < 0.5:
            raise ScenarioError(f"{where}.step must be a small positive share, not {self.step}")
        if not math.isfinite(self._span):
            raise ScenarioError(f"{where}: give lower and upper, or a start that is not 0")

    @property
    def _span(self) -> float:
        return abs(self.start) or self.upper - self.lower


@dataclass(frozen=True)
class Estimate:
    """A value and the interval that holds the true one with `CONFIDENCE`.

    `widest` is how wide an interval still says something of the value.
    """

    value: float
    lower: float
    upper: float
    widest: float

    @property
    def determined(self) -> bool:
        """Whether the series determine it: its interval is no wider than `widest`."""
        return self.upper - self.lower <= self.widest


@dataclass(frozen=True)
class Fit:
    """What was found.

    Attributes
    ----------
    estimates
        By parameter.
    residuals
        What the fitted model gives less what was measured, in the series' unit.
    evaluations
        How often the model was asked.
    converged
        Whether the search ended by itself.
    """

    estimates: dict[str, Estimate]
    residuals: Floats
    evaluations: int
    converged: bool

    @property
    def undetermined(self) -> tuple[str, ...]:
        """The parameters that the series do not determine."""
        return tuple(name for name, e in self.estimates.items() if not e.determined)


def fit(
    model: Callable[[Mapping[str, float]], Floats],
    measured: Floats,
    parameters: Mapping[str, FreeParameter],
    *,
    noise: Floats | float = 1.0,
    most_evaluations: int = 40,
) -> Fit:
    """Find the parameters by which a model comes closest to what was measured.

    Least squares within bounds (trust region). The intervals are those of the model made linear at
    the solution, its noise estimated from what remains, by Student's t: they hold where noise is
    independent from sample to sample, and where the bounds are not reached.

    Parameters
    ----------
    model
        Parameters to a series, (n,).
    measured
        (n,)
    parameters
        By name; fewer than n.
    noise
        Relative weight: the deviation that each sample is thought to have; (n,) or one for all.

    Raises
    ------
    ScenarioError
        Where there are too few samples, or a model that gives no numbers.
    """
    if len(measured) <= len(parameters):
        raise ScenarioError(
            f"{len(measured)} samples cannot tell {len(parameters)} parameters; measure more"
        )
    misfit = _Misfit(model, measured, parameters, noise)
    found = least_squares(
        misfit.residuals,
        np.zeros(len(parameters)),
        jac=misfit.slopes,
        bounds=(misfit.lower, misfit.upper),
        xtol=1e-5,
        ftol=1e-6,
        max_nfev=most_evaluations,
    )
    half = half_widths(misfit.slopes(found.x, central=True), found.fun)
    estimates = {
        name: Estimate(p.value(u), p.value(u - h), p.value(u + h), p.telling(p.value(u)))
        for (name, p), u, h in zip(parameters.items(), found.x, half, strict=True)
    }
    return Fit(estimates, found.fun * noise, misfit.evaluations, bool(found.status > 0))


class _Misfit:
    """What the model gives less what was measured, over the numbers u that are searched for."""

    def __init__(
        self,
        model: Callable[[Mapping[str, float]], Floats],
        measured: Floats,
        parameters: Mapping[str, FreeParameter],
        noise: Floats | float,
    ) -> None:
        self._model, self._measured, self._noise = model, measured, noise
        self._parameters = parameters
        self.lower = np.array([p.place(p.lower) for p in parameters.values()])
        self.upper = np.array([p.place(p.upper) for p in parameters.values()])
        self.evaluations = 0
        # The search asks for the residuals, then for the slopes at the same place.
        self._last: tuple[Floats, Floats] | None = None

    def residuals(self, u: Floats) -> Floats:
        """Return them, in units of the noise (n,); raise ScenarioError where not finite."""
        if self._last is not None and np.array_equal(u, self._last[0]):
            return self._last[1]
        self.evaluations += 1
        names = self._parameters.items()
        values = {name: p.value(x) for (name, p), x in zip(names, u, strict=True)}
        off = np.asarray((self._model(values) - self._measured) / self._noise, dtype=np.float64)
        if not np.isfinite(off).all():
            raise ScenarioError(f"the model gives no numbers at {_listed(values)}")
        self._last = u.copy(), off
        return off

    def slopes(self, u: Floats, *, central: bool = False) -> Floats:
        """Return their derivatives (n, p); central ones within the bounds, for the intervals."""
        columns = []
        here = self.residuals(u)
        for index, p in enumerate(self._parameters.values()):
            step = np.zeros(len(u))
            step[index] = p.step if u[index] + p.step <= self.upper[index] else -p.step
            ahead = self.residuals(u + step)
            inside = self.lower[index] <= u[index] - step[index] <= self.upper[index]
            if central and inside:
                columns.append((ahead - self.residuals(u - step)) / (2.0 * step[index]))
            else:
                columns.append((ahead - here) / step[index])
        return np.stack(columns, axis=1)


def half_widths(slopes: Floats, residuals: Floats) -> Floats:
    """Return half the widths of the intervals of a linear model, (p,); inf where undetermined."""
    n, p = slopes.shape
    _, sizes, rows = np.linalg.svd(slopes, full_matrices=False)
    known = sizes > _UNKNOWN * max(sizes.max(), 1e-300)
    variance = residuals @ residuals / (n - p)
    spread = ((rows[known] / sizes[known, None]) ** 2).sum(axis=0)
    spread[(np.abs(rows[~known]) > 1e-6).any(axis=0)] = np.inf
    return np.asarray(student.ppf(0.5 + CONFIDENCE / 2.0, n - p) * np.sqrt(variance * spread))


def _listed(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
