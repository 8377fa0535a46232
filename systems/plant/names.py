"""Find bodies of a plant by the names users give them."""

from __future__ import annotations

import difflib
from collections import defaultdict
from collections.abc import Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody


class BodyNames:
    """The bodies of a plant by name: `body` where that is unambiguous, else `model::body`."""

    def __init__(self, plant: MultibodyPlant) -> None:
        bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
        self._by_name: dict[str, list[RigidBody]] = defaultdict(list)
        for body in bodies:
            self._by_name[body.name()].append(body)
            if (full := body.scoped_name().get_full()) != body.name():
                self._by_name[full].append(body)
        self._names = [
            body.name() if len(self._by_name[body.name()]) == 1 else body.scoped_name().get_full()
            for body in bodies
        ]

    def name_of(self, index: BodyIndex) -> str:
        """Return the shortest name that finds the body."""
        return self._names[int(index)]

    def find(self, name: str, where: str) -> BodyIndex:
        """Return the body called `name`; raises ValueError telling `where` the name stood."""
        found = self._by_name.get(name, [])
        if len(found) == 1:
            return found[0].index()
        if found:
            choices = ", ".join(body.scoped_name().get_full() for body in found)
            raise ValueError(f"{where}: several bodies are called {name!r}; say which: {choices}")
        near = difflib.get_close_matches(name, list(self._by_name), n=3, cutoff=0.4)
        hint = f"did you mean {', '.join(near)}?" if near else f"there are {', '.join(self._names)}"
        raise ValueError(f"{where}: the plant has no body {name!r}; {hint}")

    def find_two(self, names: Sequence[str], where: str) -> tuple[BodyIndex, BodyIndex]:
        """Return two different bodies, lower index first; raises ValueError telling `where`."""
        if len(names) != 2:
            raise ValueError(f"{where}: give two body names, not {len(names)}: {list(names)}")
        a, b = sorted((self.find(name, where) for name in names), key=int)
        if a == b:
            raise ValueError(f"{where}: {names[0]!r} cannot touch itself")
        return a, b
