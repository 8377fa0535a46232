"""Figures that a scenario file defines itself: arithmetic over the columns of its time series.

A column is a text, `"ball.z"`, and so is arithmetic of columns, `"ball.z" - "table.z"`, sample by
sample. It may be used only as the first argument of a function of columns:

start(c), end(c)      value at the beginning; mean over the acceptance window
at(c, t)              value at a time
mean(c, t0, t1)       mean between two times
slope(c, t0, t1)      slope of the straight line fitted between two times
low(c), high(c)       extremes; low(c, t0, t1), high(c, t0, t1) between two times
rms(c, t0, t1)        root mean square of the deviation from the mean between two times
travel(c)             largest deviation from the value at the beginning
spread(c)             largest less smallest value in the acceptance window
total(c, t0, t1)      integral over time
when_above(c, x), when_below(c, x)   first time beyond a value, NaN if never
abs sqrt sin cos tan asin acos atan log exp max min, pi, g (9.81)
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.format.errors import ScenarioError
from scenarios.simulation.record import Record

_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Gt: operator.gt,
    ast.Lt: operator.lt,
}
_PLAIN: dict[str, Callable[..., float]] = {
    "abs": abs,
    "max": max,
    "min": min,
    **{
        name: getattr(math, name)
        for name in ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "log", "exp")
    },
}
_CONSTANTS = {"pi": math.pi, "g": 9.81}


def check_expression(where: str, expression: str) -> None:
    """Raise ScenarioError, naming the place, if an expression cannot be evaluated on any record."""
    try:
        tree = ast.parse(expression, mode="eval").body
    except (SyntaxError, ValueError) as error:
        raise ScenarioError(f"{where}: '{expression}' is not arithmetic: {error}") from error
    for node in ast.walk(tree):
        _check_node(where, expression, node)
    if _is_column(where, tree):
        raise ScenarioError(f"{where}: '{expression}' is a column, not a number; take {_TAKE}")


_TAKE = "its end, mean, high or another function of a column"


def _is_column(where: str, node: ast.AST) -> bool:
    """Whether a value is a column; raises ScenarioError where it is not what a function takes."""
    match node:
        case ast.Constant(value=value):
            return isinstance(value, str)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            columns = [_is_column(where, argument) for argument in arguments]
            if columns != [name in _COLUMN_FUNCTIONS, *[False] * (len(columns) - 1)]:
                raise ScenarioError(
                    f"{where}: {ast.unparse(node)}: {name} takes "
                    + ("a column, then numbers" if name in _COLUMN_FUNCTIONS else "numbers")
                )
            return False
        case _:
            children = [_is_column(where, child) for child in ast.iter_child_nodes(node)]
            return any(children)


def _check_node(where: str, expression: str, node: ast.AST) -> None:
    known = (*_COLUMN_FUNCTIONS, *_PLAIN)
    if isinstance(node, ast.Call):
        name = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
        if name not in known or node.keywords:
            raise ScenarioError(f"{where}: no function {name}; there are: {', '.join(known)}")
    elif isinstance(node, ast.Name):
        if node.id not in known and node.id not in _CONSTANTS:
            hint = f'; a column is a text: end("{node.id}.z")'
            raise ScenarioError(f"{where}: '{node.id}' means nothing{hint}")
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, int | float | str):
            raise ScenarioError(f"{where}: {node.value!r} is neither a number nor a column")
    elif isinstance(node, ast.BinOp | ast.UnaryOp):
        if type(node.op) not in _OPERATORS:
            raise ScenarioError(f"{where}: '{expression}' uses more than arithmetic")
    elif not isinstance(node, ast.operator | ast.unaryop | ast.Load | ast.Compare | ast.cmpop):
        raise ScenarioError(f"{where}: '{expression}' uses more than arithmetic")


def columns_in(expression: str) -> Iterator[str]:
    """Yield the columns that an expression reads."""
    for node in ast.walk(ast.parse(expression, mode="eval")):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def evaluate(expression: str, record: Record, window: float) -> float:
    """Return the value of a checked expression; NaN where a value does not exist."""
    try:
        return float(_value(ast.parse(expression, mode="eval").body, record, window))
    except (ZeroDivisionError, OverflowError, ValueError):
        return math.nan


def _value(node: ast.AST, record: Record, window: float) -> Any:
    match node:
        case ast.Constant(value=str(column)):
            return record[column]
        case ast.Constant():
            return node.value
        case ast.Name():
            return _CONSTANTS[node.id]
        case ast.BinOp():
            left, right = (_value(side, record, window) for side in (node.left, node.right))
            return _OPERATORS[type(node.op)](left, right)
        case ast.UnaryOp():
            return _OPERATORS[type(node.op)](_value(node.operand, record, window))
        case ast.Compare():
            left, right = (_value(n, record, window) for n in (node.left, node.comparators[0]))
            return float(_OPERATORS[type(node.ops[0])](left, right))
        case ast.Call(func=ast.Name(id=name)):
            arguments = [_value(argument, record, window) for argument in node.args]
            if name in _PLAIN:
                return _PLAIN[name](*arguments)
            return _COLUMN_FUNCTIONS[name](record["time"], arguments[0], window, *arguments[1:])
    raise ValueError(ast.dump(node))


Floats = NDArray[np.float64]


def _between(time: Floats, values: Floats, span: tuple[float, ...]) -> tuple[Floats, Floats]:
    if not span:
        return time, values
    inside = (time >= span[0] - 1e-9) & (time <= span[1] + 1e-9)
    return time[inside], values[inside]


def _end(time: Floats, values: Floats, window: float) -> Floats:
    return values[time >= time[-1] - window]


def _first(time: Floats, hit: NDArray[np.bool_]) -> float:
    return float(time[np.argmax(hit)]) if hit.any() else math.nan


def _slope(time: Floats, values: Floats, _: float, *span: float) -> float:
    time, values = _between(time, values, span)
    return float(np.polyfit(time, values, 1)[0]) if len(time) > 1 else math.nan


def _mean(time: Floats, values: Floats, _: float, *span: float) -> float:
    inside = _between(time, values, span)[1]
    return float(inside.mean()) if len(inside) else math.nan


_COLUMN_FUNCTIONS: dict[str, Callable[..., float]] = {
    "start": lambda _time, values, _window: float(values[0]),
    "end": lambda time, values, window: float(_end(time, values, window).mean()),
    "at": lambda time, values, _window, t: float(np.interp(t, time, values)),
    "mean": _mean,
    "slope": _slope,
    "low": lambda time, values, _, *span: float(_between(time, values, span)[1].min()),
    "high": lambda time, values, _, *span: float(_between(time, values, span)[1].max()),
    "rms": lambda time, values, _, *span: float(_between(time, values, span)[1].std()),
    "travel": lambda _time, values, _window: float(np.abs(values - values[0]).max()),
    "spread": lambda time, values, window: float(np.ptp(_end(time, values, window))),
    "total": lambda time, values, _, *span: float(
        np.trapezoid(*_between(time, values, span)[::-1])
    ),
    "when_above": lambda time, values, _, x: _first(time, values > x),
    "when_below": lambda time, values, _, x: _first(time, values < x),
}
