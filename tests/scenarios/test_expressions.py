"""Figures by expression: values against numpy, and nothing but arithmetic gets through."""

import math

import numpy as np
import pytest

from scenarios.format.errors import ScenarioError
from scenarios.judge.expressions import check_expression, columns_in, evaluate
from scenarios.simulation.record import Record

TIME = np.linspace(0.0, 2.0, 201)
RECORD = Record({"time": TIME, "b.x": 3.0 * TIME**2, "b.w": np.sin(np.pi * TIME)}, {})


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ('start("b.x")', 0.0),
        ('end("b.x")', (3 * TIME[TIME >= 1.5] ** 2).mean()),
        ('at("b.x", 0.5)', 0.75),
        ('slope("b.x", 0, 1)', np.polyfit(TIME[:101], 3 * TIME[:101] ** 2, 1)[0]),
        ('high("b.w") - low("b.w", 0, 1)', 1.0),
        ('travel("b.x")', 12.0),
        ('total("b.x", 0, 2)', 8.0),
        ('when_above("b.x", 0.7499)', 0.5),
        ('high(2 * "b.x" - "b.w" / 2, 0, 1)', (6 * TIME**2 - np.sin(np.pi * TIME) / 2)[:101].max()),
        ("sqrt(16) ** 2 / -4 + pi - pi", -4.0),
        ('1e3 * (at("b.x", 1) < 4)', 1e3),
    ],
)
def test_values(expression, value):
    """A scenario would be judged by another number than its file says."""
    check_expression("here", expression)
    assert evaluate(expression, RECORD, 0.5) == pytest.approx(value, rel=1e-3, abs=1e-12)


@pytest.mark.parametrize("expression", ['when_above("b.x", 99)', "1 / 0", "sqrt(-1)"])
def test_what_does_not_exist_is_nan_and_meets_no_limit(expression):
    """A missing figure would end the run in a traceback, or pass."""
    check_expression("here", expression)
    assert math.isnan(evaluate(expression, RECORD, 0.5))


@pytest.mark.parametrize(
    ("expression", "complaint"),
    [
        ("__import__('os').system('true')", "no function"),
        ("(1).__class__", "more than arithmetic"),
        ("[x for x in 'abc']", "more than arithmetic"),
        ("lambda: 1", "more than arithmetic"),
        ("exec('1')", "no function exec"),
        ("end(ball)", r"'ball' means nothing; a column is a text"),
        ('2 * "b.x"', "is a column, not a number"),
        ("end(2)", "end takes a column, then numbers"),
        ('at("b.x", "b.w")', "at takes a column, then numbers"),
        ('sqrt("b.x" - 1)', "sqrt takes numbers"),
        ("1 +", "not arithmetic"),
        ("1 if 2 else 3", "more than arithmetic"),
        ("True", "neither a number nor a column"),
        ("2 << 3", "more than arithmetic"),
    ],
)
def test_anything_else_is_refused_with_its_place(expression, complaint):
    """A scenario from a stranger would run code, or a slip would show only after the run."""
    with pytest.raises(ScenarioError, match=f"acceptance.figures.x: .*{complaint}"):
        check_expression("acceptance.figures.x", expression)


def test_columns_are_known_before_the_run():
    """A misspelt column would show only after minutes of simulation."""
    assert list(columns_in('end("a.z") - 2 * start("b.z")')) == ["a.z", "b.z"]
