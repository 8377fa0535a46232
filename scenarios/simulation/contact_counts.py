"""A system that counts springs and the facet pairs behind them, for logging."""

from __future__ import annotations

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem


class ContactCounts(LeafSystem):
    """Contacts in (any value with an array `multiplicity`); out: springs, facet pairs."""

    def __init__(self) -> None:
        LeafSystem.__init__(self)
        self.DeclareAbstractInputPort("contacts", AbstractValue.Make(object()))
        self.DeclareVectorOutputPort("counts", 2, self._count)

    def _count(self, context: Context, counts: BasicVector) -> None:
        multiplicity = self.get_input_port().Eval(context).multiplicity
        counts.SetFromVector([len(multiplicity), multiplicity.sum()])
