"""A body of a scenario made by a generator or from a mesh file."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses


@dataclasses.dataclass
class Part:
    """A body made by a generator of ours or from a mesh file, at `package://parts/NAME.sdf`.

    The same stands at `package://parts/NAME.urdf`, which Drake reads faster.

    Attributes
    ----------
    generator, parameters
        A function of `scenarios.parts` (see `contact-toolkit parts`) and its arguments.
    mesh
        Instead of a generator: a mesh file (.stl, .ply, .obj, .off, .glb, .gltf), relative to the
        scenario's file.
    scale
        Factor from the mesh file's unit to metres: 0.001 for millimetres. Of a generated part, how
        many times as large it is.
    density
        [kg/m³]; mass and inertia are those of the faceted solid.
    mass
        [kg]; unless 0, the density is chosen to give this mass.
    rgba
        Colour, red, green, blue and opacity from 0 to 1.
    """

    generator: str = ""
    parameters: dict[str, float] = dataclasses.field(default_factory=dict)
    mesh: str = ""
    scale: float = 1.0
    density: float = 1000.0
    mass: float = 0.0
    rgba: list[float] = dataclasses.field(default_factory=lambda: [0.7, 0.7, 0.7, 1.0])
