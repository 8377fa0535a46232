"""Drake systems that put the contact toolkit into a multibody plant."""

from systems.add_nonlinear_damper_contact import AddNonlinearDamperContact
from systems.contact_config import ContactConfig, ContactLawConfig, FrictionConfig, PairConfig
from systems.cspace_model import PlantCSpace
from systems.nonlinear_damper_contact import NonlinearDamperContact
from systems.swept_contact_monitor import SweptContactMonitor
from systems.witness_pair_visualizer import WitnessPairVisualizer

__all__ = [
    "AddNonlinearDamperContact",
    "ContactConfig",
    "ContactLawConfig",
    "FrictionConfig",
    "NonlinearDamperContact",
    "PairConfig",
    "PlantCSpace",
    "SweptContactMonitor",
    "WitnessPairVisualizer",
]
