"""The protocol of generators: parameters in, objects with exact truth out.

A generator is a `Generator`: name, title, a frozen data class of parameters, and a pure function from these to a
`GeneratedSet`. Objects are described in a frame with z up and front +x at rest (all joints at zero), in metres; where
its origin lies does not matter, `assetkit.generate.write` moves it to the bottom centre.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from assetkit.generate.parameters import checked
from assetkit.generate.shape import Shape
from assetkit.generate.truth import TrueClearance, TrueHole, TrueInterior
from assetkit.taxonomy.material_classes import materials
from geom.mass.inertia import combine
from schemas.mechanism import MechanismJoint
from schemas.physics import MassProperties

# Display colours (sRGB, 0..1) by their basic terms, as `assetkit.materials.colour_names` reads them back.
COLOURS: dict[str, tuple[float, float, float]] = {
    "red": (0.80, 0.10, 0.10),
    "green": (0.13, 0.55, 0.20),
    "blue": (0.10, 0.25, 0.80),
    "yellow": (0.95, 0.80, 0.10),
    "orange": (0.95, 0.50, 0.08),
    "purple": (0.45, 0.15, 0.60),
    "pink": (0.95, 0.55, 0.70),
    "brown": (0.45, 0.27, 0.12),
    "white": (0.93, 0.93, 0.93),
    "grey": (0.55, 0.55, 0.57),
    "black": (0.08, 0.08, 0.08),
    "oak": (0.72, 0.54, 0.33),
}
PAINTS = tuple(name for name in COLOURS if name != "oak")  # what a coloured prop may be painted with
P = TypeVar("P")


@dataclass(frozen=True)
class GeneratedPart:
    """One closed body of a link: its name in the words of the taxonomy, its shape, material class and colour."""

    name: str
    shape: Shape
    material: str
    colour: str

    @property
    def mass(self) -> MassProperties:
        """Filled with the usual density of its material."""
        return self.shape.volume.filled(materials()[self.material].density_kgm3)


@dataclass(frozen=True)
class GeneratedLink:
    """One rigid body of one or more parts, which touch and do not overlap."""

    name: str
    parts: tuple[GeneratedPart, ...]

    @property
    def mass(self) -> MassProperties:
        """That of all parts."""
        return combine([part.mass for part in self.parts])


@dataclass(frozen=True)
class GeneratedObject:
    """One object: links, the root first and parents before children, joints that are at zero at rest, and truth."""

    name: str
    links: tuple[GeneratedLink, ...]
    joints: tuple[MechanismJoint, ...] = ()
    interiors: tuple[TrueInterior, ...] = ()
    holes: tuple[TrueHole, ...] = ()


@dataclass(frozen=True)
class GeneratedSet:
    """What one run makes: objects that belong together, and the room that they leave each other."""

    objects: tuple[GeneratedObject, ...]
    clearances: tuple[TrueClearance, ...] = ()


@dataclass(frozen=True)
class Generator(Generic[P]):
    """A program for one kind of object: `build` is pure and deterministic, for any parameters within their ranges."""

    name: str
    title: str
    parameters: type[P]
    build: Callable[[P], GeneratedSet]

    def run(self, values: Any = None) -> GeneratedSet:
        """The objects for `values`, by default the defaults; raises ParameterError for values outside their ranges."""
        return self.build(checked(self.parameters() if values is None else values))
