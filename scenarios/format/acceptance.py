"""How the run of a scenario is judged."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses
import math

from scenarios.format.errors import ScenarioError


@dataclasses.dataclass
class Limit:
    """Bounds on one measured figure; those left out do not apply.

    Attributes
    ----------
    near, within
        The expected value and the largest deviation from it.
    at_least, at_most
        One-sided bounds.
    """

    near: float | None = None
    within: float | None = None
    at_least: float | None = None
    at_most: float | None = None

    def check(self, name: str) -> None:
        """Raise ScenarioError if the bounds do not make sense."""
        if (self.near is None) != (self.within is None):
            raise ScenarioError(f"{name} needs both near and within")
        if not str(self):
            raise ScenarioError(f"{name} bounds nothing")
        given = {"near": self.near, "at_least": self.at_least, "at_most": self.at_most}
        for bound, value in {**given, "within": self.within}.items():
            if value is not None and not math.isfinite(value):
                raise ScenarioError(f"{name}.{bound} must be a finite number, not {value}")
        if self.within is not None and self.within < 0.0:
            raise ScenarioError(f"{name}.within must not be negative, as {self.within} is")
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            raise ScenarioError(
                f"{name} can never hold: at_least {self.at_least:g} is above "
                f"at_most {self.at_most:g}"
            )

    def holds(self, value: float) -> bool:
        """Whether a measured value meets every bound given; NaN meets none."""
        return not math.isnan(value) and all(
            (
                self.near is None or self.within is None or abs(value - self.near) <= self.within,
                self.at_least is None or value >= self.at_least,
                self.at_most is None or value <= self.at_most,
            )
        )

    def __str__(self) -> str:
        bounds = []
        if self.near is not None:
            bounds.append(f"{self.near:g} ± {self.within:g}")
        if self.at_least is not None:
            bounds.append(f"≥ {self.at_least:g}")
        if self.at_most is not None:
            bounds.append(f"≤ {self.at_most:g}")
        return ", ".join(bounds)


@dataclasses.dataclass
class Acceptance:
    """How a run is judged.

    Attributes
    ----------
    measure
        A function of `scenarios.judge.measures` that turns a finished run into named figures.
    body
        The body it looks at.
    window
        The last part of the run that counts as the end state [s].
    figures
        Further figures by name, each an expression over the columns of the time series: see
        `scenarios.judge.expressions`.
    limits
        Bounds on some of the figures; the run passes if all hold.
    truth
        What the limits are taken from, in words, for the table of results.
    """

    measure: str = ""
    body: str = ""
    window: float = 0.5
    figures: dict[str, str] = dataclasses.field(default_factory=dict)
    limits: dict[str, Limit] = dataclasses.field(default_factory=dict)
    truth: str = ""
