"""Content of one asset package for the USD writer: model, shapes, mass and texts (m, kg, asset frame)."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.anchors import Point3
from schemas.mechanism import Mechanism
from schemas.model import Model
from schemas.parts import Part
from schemas.physics import CollisionShape, Contact, MassProperties, SurfaceMaterial

GraspLines = tuple[tuple[Point3, Point3], ...]  # The two ends of the line of each grasp, asset frame, metres.


@dataclass(frozen=True)
class LinkBody:
    """One link of an articulated object: its mass properties, and its shapes by their indices among those of the
    object; all in the asset frame at rest.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    shapes: tuple[int, ...]
    mass: MassProperties


@dataclass(frozen=True)
class PackageContent:
    """One asset ready to be written: canonical model (metres, z-up, bottom-centre origin) and its physics.

    `surfaces` are the contact materials when parts differ, that of the largest part first; `shape_surfaces` says for
    each shape which of them it has. When empty, every shape has `contact`, `physical_material` and `density_kgm3`.
    `grasp_lines_m` are the two ends of each grasp's line, asset frame, the best grasp first.
    `parts` become face subsets of the meshes.
    `mechanism` is that of an articulated object in the asset frame, `links` the bodies of its links in the same order,
    `filtered_pairs` links that do not collide; `shapes` and `mass` are then those of all links at rest.
    `thumbnail_png` is a 256x256 PNG. Texts are "unknown" where nothing is known; they are never invented.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    asset_id: str
    model: Model
    shapes: tuple[CollisionShape, ...]
    mass: MassProperties
    contact: Contact
    physical_material: str
    density_kgm3: float
    category: str
    qcode: str
    license: str
    author: str
    source_file: str
    thumbnail_png: bytes
    surfaces: tuple[SurfaceMaterial, ...] = ()
    shape_surfaces: tuple[int, ...] = ()
    grasp_lines_m: GraspLines = ()
    parts: tuple[Part, ...] = ()
    mechanism: Mechanism | None = None
    links: tuple[LinkBody, ...] = ()
    filtered_pairs: tuple[tuple[str, str], ...] = ()
