"""ContactSystem: a LeafSystem that Drake can convert from doubles to AutoDiffXd."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

if TYPE_CHECKING:  # classes that are made at run time are none to a type checker
    from pydrake.systems.framework import LeafSystem as ContactSystem
else:

    @TemplateSystem.define(
        "ContactSystem_", T_list=[float, AutoDiffXd], T_pairs=[(AutoDiffXd, float)]
    )
    def ContactSystem_(T):
        """Return the class for a scalar type.

        What inherits from that for doubles says in `convert_to(system)` what becomes of it: which
        ports and state it declares in a system of AutoDiffXd.
        """

        class Impl(LeafSystem_[T]):
            def _construct(self, converter=None):
                LeafSystem_[T].__init__(self, converter=converter)

            def _construct_copy(self, other, converter=None):
                Impl._construct(self, converter=converter)
                other.convert_to(self)

        return Impl

    ContactSystem = ContactSystem_[float]

__all__ = ["ContactSystem"]
