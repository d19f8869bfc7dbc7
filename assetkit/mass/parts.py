"""The parts an object's mass is made of: each substance with its body, as heavy as stated or as dense as known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.mass.bounds import is_full
from assetkit.mass.source_inertials import Judged, judge
from assetkit.mass.substances import Substance, substances_of, uniform
from assetkit.mass.unknown_density import unknown_density
from assetkit.taxonomy.material_classes import UNKNOWN
from geom.features.cavities import Cavity
from geom.mass.inertia import mass_properties, scaled
from geom.mass.offset_centre import squeezed
from geom.solid.volume_shares import Division, divide
from schemas.evidence import Evidence, declared
from schemas.model import FloatArray, IntArray, Mesh
from schemas.physics import MassProperties, Solid
from schemas.stated_physics import StatedMass

STATED_CONFIDENCE = 0.95
METRES: Evidence[float] = declared(1.0, "metres")


@dataclass(frozen=True)
class Clues:
    """What besides the solid tells mass (asset frame, metres).

    meshes            visual meshes, canonical; `as_read` the same before canonicalisation (for what statements cover).
    render_materials  names, by the meshes' material index.
    masses            what the source states.
    unit              metres per source unit, as sure as it is.
    wall              wall thickness (m) of an open surface, None where the solid is none.
    cavities          openings of the solid.
    dense             why a body of unknown material is likely solid or of metal (`dense_look`), "" if nothing says so.
    category          what the object is, "" while nobody knows, and what such things weigh: `usual_kg`, least and most.
    category_confidence, names  how sure that is, and what the object is called, the most telling name first.
    without_row       measured object whose row of `usual_masses.csv` is left out, as benchmarks do; "" for none.
    touch        materials of the visible surface by looks, names and use, that of the whole first; `of_face` says per
                 mesh which of them each triangle has (`face_materials`).
    """

    meshes: tuple[Mesh, ...] = ()
    as_read: tuple[Mesh, ...] = ()
    render_materials: tuple[str, ...] = ()
    masses: tuple[StatedMass, ...] = ()
    unit: Evidence[float] = METRES
    wall: Evidence[float] | None = None
    cavities: tuple[Cavity, ...] = ()
    dense: str = ""
    category: str = ""
    usual_kg: tuple[float, float] | None = None
    category_confidence: float = 0.0
    names: tuple[str, ...] = ()
    without_row: str = ""
    touch: tuple[Evidence[str], ...] = ()
    of_face: tuple[IntArray, ...] = ()


@dataclass(frozen=True)
class Part:
    """A substance with the body it fills at 1 kg/m3 (`even`) and as heavy as it is taken to be (`body`).

    `rival` is the even body when volume that parts share goes to the others, for `shared` tells why it does not.
    `squeeze` is that of the verdict on its statement (`Judged`).
    """

    substance: Substance
    even: MassProperties
    body: MassProperties
    rival: MassProperties | None = None
    shared: str = ""
    squeeze: FloatArray | None = None

    @property
    def rival_body(self) -> MassProperties:
        """The body as heavy as it is in the other reading; the same one where there is none."""
        return self.body if self.rival is None else _weighed(self.substance, self.rival, self.squeeze)

    @property
    def unsqueezed_body(self) -> MassProperties:
        """The body with its tensor as evenly filled, whether it fits about the mass centre or not."""
        return _weighed(self.substance, self.even, None)

    @property
    def confidence(self) -> float:
        """How sure its mass is, apart from the geometry."""
        return STATED_CONFIDENCE if self.substance.stated is not None else self.substance.density_kgm3.confidence


def parts_of(
    solid: Solid, whole: Sequence[str], clues: Clues, masses: Sequence[StatedMass]
) -> tuple[list[Part], bool, list[Judged]]:
    """The substances with their bodies, whether these have places of their own, and the verdicts on statements."""
    full = is_full(solid, clues.cavities)
    even = mass_properties(solid, 1.0)[0]
    sure = solid.kind == "closed" and solid.walls is None
    judged = [judge(s, solid.points, even, exact=sure) for s in masses if s.mass_kg is None]
    kept = [s for s in masses if s.mass_kg is not None] + [j.stated for j in judged if j.stated is not None]
    substances = substances_of(clues.meshes, clues.render_materials, whole, kept, full=full)
    if not clues.meshes:
        substances = (uniform(whole, full=full),)
    if not full:
        substances = _sized(substances, solid, clues.dense)
    made = Division((even,), True)
    if len(substances) > 1:
        groups = [[clues.meshes[i] for i in substance.meshes] for substance in substances]
        made = divide(solid, groups, [s.density_kgm3.value for s in substances])
    exact, parts = made.exact, list[Part]()
    for substance, body, rival in zip(substances, made.shares, made.rival or [None] * len(substances), strict=True):
        stated, squeeze = substance.stated, None
        if stated is not None:
            points = solid.points
            if len(substances) > 1:
                points = np.concatenate([clues.meshes[i].points for i in substance.meshes])
            if not exact:
                stated = replace(stated, centre=None, inertia=None)  # Nothing to hold them against.
            verdict = judge(stated, points, body, exact=exact and sure)
            judged.append(verdict)
            substance, squeeze = replace(substance, stated=verdict.stated), verdict.squeeze
        parts.append(Part(substance, body, _weighed(substance, body, squeeze), rival, made.reason, squeeze))
    return parts, exact, judged


def _sized(substances: Sequence[Substance], solid: Solid, dense: str) -> tuple[Substance, ...]:
    """The substances, unknown ones as dense as things of the size of `solid` are."""
    density = unknown_density(solid, dense)
    return tuple(
        replace(s, density_kgm3=density)
        if density is not None and s.material.value == UNKNOWN and s.density_kgm3.source == "default"
        else s
        for s in substances
    )


def _weighed(substance: Substance, even: MassProperties, squeeze: FloatArray | None) -> MassProperties:
    """`even` as heavy as the source states, with its mass centre and tensor if stated, else as dense as known."""
    stated = substance.stated
    if stated is None or stated.mass_kg is None:
        return scaled(even, substance.density_kgm3.value)
    body = scaled(even, stated.mass_kg / even.mass_kg)
    if squeeze is not None:
        body = replace(body, inertia_kgm2=squeezed(body.inertia_kgm2, squeeze))
    return MassProperties(
        stated.mass_kg,
        body.centre_of_mass_m if stated.centre is None else stated.centre,
        body.inertia_kgm2 if stated.inertia is None else stated.inertia,
    )
