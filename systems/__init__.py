"""Drake systems that put the contact toolkit into a multibody plant."""

from systems.add_mesh_body import MeshBody, add_mesh_body
from systems.add_nonlinear_damper_contact import AddNonlinearDamperContact
from systems.contact_config import ContactConfig, ContactLawConfig, FrictionConfig, PairConfig
from systems.monitors.contact_force_visualizer import ContactForceVisualizer
from systems.monitors.pair_wrenches import PairWrenches
from systems.monitors.swept_contact_monitor import SweptContactMonitor
from systems.monitors.witness_pair_visualizer import WitnessPairVisualizer
from systems.nonlinear_damper_contact import NonlinearDamperContact
from systems.parse_model import parse_model
from systems.plant_cspace import PlantCSpace
from systems.saved_context import SavedContext
from systems.step.linearized_step import LinearizedStep
from systems.wiring.station import OpenForcePorts

__all__ = [
    "AddNonlinearDamperContact",
    "ContactConfig",
    "ContactForceVisualizer",
    "ContactLawConfig",
    "FrictionConfig",
    "LinearizedStep",
    "MeshBody",
    "NonlinearDamperContact",
    "OpenForcePorts",
    "PairConfig",
    "PairWrenches",
    "PlantCSpace",
    "SavedContext",
    "SweptContactMonitor",
    "WitnessPairVisualizer",
    "add_mesh_body",
    "parse_model",
]
