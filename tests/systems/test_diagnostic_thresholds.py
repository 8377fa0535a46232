"""Chatter and StepResolution: each threshold is where it is said to be, fed with made-up steps."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from systems.diagnostics.accepted_step import AcceptedStep
from systems.diagnostics.chatter import Chatter, Streak
from systems.diagnostics.step_resolution import Ledger, StepResolution

MODEL = SimpleNamespace(
    geometries=[SimpleNamespace(mesh=SimpleNamespace(diagonal=1.0))],
    pair_names=lambda _pair: ("cup", "table"),
)


class Springs(list):
    """Loaded springs, or none."""

    def __init__(self, count: int) -> None:
        super().__init__(range(count))
        self.status = np.zeros(count, dtype=int)
        self.p_FBo = np.zeros((1, 3))


class Contacts(SimpleNamespace):
    def __len__(self) -> int:
        return len(self.pair)


def forces(torque=0.0, *, stored=0.0, velocity=0.0, loaded=1):
    contacts = Contacts(
        pair=np.zeros(loaded, dtype=int),
        normal_force=np.ones(loaded),
        deformation=np.full(loaded, 1e-3),
        rate=np.ones(loaded),
    )
    return SimpleNamespace(
        loaded=Springs(loaded),
        contacts=contacts,
        body_wrenches=np.array([[torque, 0, 0, 0, 0, 1.0]]),
        stored=stored,
        power_given=0.0,
        V_FB=np.array([[0, 0, 0, velocity, 0, 0]]),
    )


def step(start, end, duration, since=0.0, lost=0.0):
    return AcceptedStep(
        SimpleNamespace(time=since, forces=start, lost=0.0),
        SimpleNamespace(time=since + duration, lost=lost),
        end,
    )


def frequency(value: float) -> SimpleNamespace:
    return SimpleNamespace(bound=lambda _X, _contacts: value)


def run_chatter(durations, torques=(1.0, 1.0), omega=1.0) -> int:
    """Return how many steps were taken when chatter was reported; 0: it was not."""
    watch, streak, time = Chatter(MODEL, frequency(omega), "raise"), Streak(), 0.0
    for i, duration in enumerate(durations):
        start, end = (forces(torques[(i + k) % 2]) for k in range(2))
        try:
            streak = watch.check(streak, step(start, end, duration, time), lambda: None)
        except RuntimeError:
            return i + 1
        time += duration
    return 0


TINY, LEAST = 5e-12, 5e-14


@pytest.mark.parametrize(
    ("durations", "reported_at"),
    [
        ([LEAST] * 10, 4),
        ([LEAST] * 3 + [1e-3], 0),  # three are no streak
        ([TINY] * 50, 0),  # tiny, yet none next to the least
        ([TINY] * 3 + [LEAST], 4),
        ([3e-11] * 3 + [LEAST], 0),  # three that are not tiny
        ([2e-13] * 50, 0),  # none next to the least
    ],
)
def test_tiny_steps_in_a_row(durations, reported_at):
    """An integrator about to give up that is not reported, or one that is not, is."""
    assert run_chatter(durations) == reported_at


@pytest.mark.parametrize(
    ("phase", "leap", "reported_at"),
    [(0.09, 0.02, 2000), (0.2, 0.02, 0), (0.09, 0.005, 0)],
)
def test_steps_that_get_nowhere_while_torque_leaps(phase, leap, reported_at):
    """A thousand steps over `phase` of the swing [rad], torque changing by `leap` in each."""
    assert run_chatter([phase / 1000] * 2500, (1.0, 1.0 - leap)) == reported_at


@pytest.mark.parametrize(("torque", "reported_at"), [(2e-8, 2000), (5e-9, 0)])
def test_torque_that_is_rounding_does_not_leap(torque, reported_at):
    """Under 1 N on a geometry of 1 m, a millionth of a newton metre counts as the least torque."""
    assert run_chatter([9e-5] * 2500, (torque, 0.0)) == reported_at


def bounce(ledger: Ledger, off: float) -> tuple[Ledger, list[str]]:
    """Store 1 J in a step whose balance is off by `off`, and give it back; return the warnings."""
    resolution = StepResolution(MODEL, frequency(100.0), gravity=0.0)
    empty, full = forces(stored=0.0), forces(stored=1.0)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        ledger = resolution.check(ledger, step(empty, full, 1e-3, lost=off - 1), lambda: None)
        ledger = resolution.check(ledger, step(full, empty, 1e-3, lost=1.0), lambda: None)
    return ledger, [str(each.message) for each in found]


def test_a_step_off_by_a_quarter_of_the_energy_is_reported():
    """A step too long for a bounce in silence, or a good one reported; the mend in figures."""
    assert bounce(Ledger(), 0.24)[1] == []
    ledger, (message,) = bounce(Ledger(), 0.3)
    assert "off by 30% of the energy" in message
    assert "set_target_accuracy(1e-04)" in message  # 1 % of 1 m/s / 100 rad/s
    assert bounce(ledger, 0.44)[1] == []  # not half as bad again
    assert len(bounce(ledger, 0.5)[1]) == 1


def test_longest_step_to_ask_for_is_a_fraction_of_the_swing():
    """0.3 rad of it, where that is shorter than half the step."""
    resolution = StepResolution(MODEL, frequency(1e4), gravity=0.0)
    empty, full = forces(stored=0.0), forces(stored=1.0)
    ledger = resolution.check(Ledger(), step(empty, full, 1e-3, lost=-0.5), lambda: None)
    with pytest.warns(RuntimeWarning, match=r"set max_step to 3e-05 s"):
        resolution.check(ledger, step(full, empty, 1e-3, lost=1.0), lambda: None)


@pytest.mark.parametrize(("after", "reported"), [(0.55, False), (0.4, True)])
def test_contact_within_a_step_is_looked_for_where_velocity_halves(after, reported):
    """An impact between two steps that is not looked for."""
    model = SimpleNamespace(**vars(MODEL), coast=lambda _state, _duration: forces())
    resolution = StepResolution(model, frequency(100.0), gravity=0.0)
    start, end = (forces(loaded=0, velocity=v) for v in (1.0, after))
    end.loaded.p_FBo = np.array([[1e-3 * (1 + after) / 2, 0, 0]])
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        resolution.check(Ledger(), step(start, end, 1e-3), lambda: None)
    assert bool(found) == reported
