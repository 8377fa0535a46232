"""Python objects in Drake's state and cache."""

from __future__ import annotations

from collections.abc import Callable
from types import MethodType
from weakref import ref

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, ValueProducer


def holding(value: object) -> AbstractValue:
    """Return a Drake value that holds the object."""
    holder = Value[object]()
    holder.set_value(value)
    return holder


def producer(calc: Callable[[Context, AbstractValue], None]) -> ValueProducer:
    """Return what a cache entry needs to hold what a system's bound method `calc` sets.

    The entry does not own the method: the circle of system, entry and method would never be freed.
    """
    assert isinstance(calc, MethodType)
    owner, function = ref(calc.__self__), calc.__func__

    def calc_weakly(context: Context, value: AbstractValue) -> None:
        function(owner(), context, value)  # alive: a system evaluates its own cache

    return ValueProducer(allocate=Value[object], calc=calc_weakly)
