"""ContactSystem_: a LeafSystem that Drake can convert from doubles to AutoDiffXd."""

from __future__ import annotations

from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem


@TemplateSystem.define("ContactSystem_", T_list=[float, AutoDiffXd], T_pairs=[(AutoDiffXd, float)])
def ContactSystem_(T: type) -> type:  # noqa: N802  as Drake names templates
    """Return the class for a scalar type.

    That for doubles is to be inherited from; what inherits says in `convert_to(system)` what
    becomes of it: the ports and the state that it declares in a system of AutoDiffXd.
    """

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        def _construct(self, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, converter=converter)
            other.convert_to(self)

    return Impl
