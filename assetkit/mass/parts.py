"""Splits an object into bodies, one per substance, with mass properties as stated or from volume times density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.mass.bounds import is_solid_throughout
from assetkit.mass.source_inertials import CheckedStatement, check_statement
from assetkit.mass.substances import STATED_CONFIDENCE, Substance, substances_of, uniform
from assetkit.mass.unknown_density import unknown_density
from assetkit.taxonomy.material_classes import UNKNOWN
from geom.features.cavities import Cavity
from geom.mass.offset_centre import contracted_inertia
from geom.solid.solid_volume import volume_properties
from geom.solid.volume_shares import VolumeShares, divide_volume
from schemas.arrays import FloatArray, IntArray
from schemas.evidence import Evidence, declared
from schemas.model import Mesh
from schemas.physics import MassProperties, Solid, VolumeProperties
from schemas.stated_physics import StatedMass

METRES: Evidence[float] = declared(1.0, "metres")


@dataclass(frozen=True)
class MassEvidenceInputs:
    """The evidence of mass beside the solid (asset frame, metres).

    meshes                  visual meshes, canonical; `as_read` the same before canonicalisation.
    render_materials        names, by the meshes' material index.
    masses                  statements of the source.
    unit                    metres per source unit, with its confidence.
    wall                    wall thickness (m) of an open surface, None where the solid is none.
    cavities                openings of the solid.
    dense_reason            why a body of unknown material is likely solid or of metal (`dense_appearance`), "" without.
    category                id of the category, "" while unknown; `category_confidence` its confidence.
    category_range_kg       least and greatest mass of objects of the category.
    names                   names of the object, the most specific first.
    excluded_row            measured object whose row of `usual_masses.csv` is left out, as benchmarks do; "" for none.
    surface_materials       materials of the visible surface by appearance, names and use, that of the whole first.
    material_of_face        per mesh the index in `surface_materials` of each triangle (`face_materials`).
    """

    meshes: tuple[Mesh, ...] = ()
    as_read: tuple[Mesh, ...] = ()
    render_materials: tuple[str, ...] = ()
    masses: tuple[StatedMass, ...] = ()
    unit: Evidence[float] = METRES
    wall: Evidence[float] | None = None
    cavities: tuple[Cavity, ...] = ()
    dense_reason: str = ""
    category: str = ""
    category_range_kg: tuple[float, float] | None = None
    category_confidence: float = 0.0
    names: tuple[str, ...] = ()
    excluded_row: str = ""
    surface_materials: tuple[Evidence[str], ...] = ()
    material_of_face: tuple[IntArray, ...] = ()


@dataclass(frozen=True)
class SubstanceBody:
    """A substance with the volume that it fills and the `body` that this makes.

    `alternative` is the volume when what the parts share goes to the others; `overlap_reason` is the reason why it does
    not. `squeeze` is that of its checked statement (`CheckedStatement`).
    """

    substance: Substance
    volume: VolumeProperties
    body: MassProperties
    alternative: VolumeProperties | None = None
    overlap_reason: str = ""
    squeeze: FloatArray | None = None

    @property
    def alternative_body(self) -> MassProperties:
        """The body at its mass when shared volume goes to the others; `body` where parts share none."""
        return self.body if self.alternative is None else _weighed(self.substance, self.alternative, self.squeeze)

    @property
    def unsqueezed_body(self) -> MassProperties:
        """The body with its tensor as evenly filled, whether it fits about the mass centre or not."""
        return _weighed(self.substance, self.volume, None)

    @property
    def confidence(self) -> float:
        """Confidence of its mass, apart from the geometry."""
        return STATED_CONFIDENCE if self.substance.stated is not None else self.substance.density_kgm3.confidence


def substance_bodies(
    solid: Solid, whole: Sequence[str], mass_inputs: MassEvidenceInputs, masses: Sequence[StatedMass]
) -> tuple[list[SubstanceBody], bool, list[CheckedStatement]]:
    """The substances with their bodies, whether the volumes of these are exact, and the checked statements."""
    full = is_solid_throughout(solid, mass_inputs.cavities)
    solid_volume = volume_properties(solid)[0]
    sure = solid.kind == "closed" and solid.walls is None
    checked = [check_statement(s, solid.points, solid_volume, exact=sure) for s in masses if s.mass_kg is None]
    statements = [s for s in masses if s.mass_kg is not None] + [c.stated for c in checked if c.stated is not None]
    substances = substances_of(mass_inputs.meshes, mass_inputs.render_materials, whole, statements, full=full)
    if not mass_inputs.meshes:
        substances = (uniform(whole, full=full),)
    if not full:
        substances = _sized(substances, solid, mass_inputs.dense_reason)
    volumes = VolumeShares((solid_volume,), True)
    if len(substances) > 1:
        groups = [[mass_inputs.meshes[i] for i in substance.meshes] for substance in substances]
        volumes = divide_volume(solid, groups, [s.density_kgm3.value for s in substances])
    exact, parts = volumes.exact, list[SubstanceBody]()
    alternatives = volumes.alternative or [None] * len(substances)
    for substance, volume, alternative in zip(substances, volumes.shares, alternatives, strict=True):
        stated, squeeze = substance.stated, None
        if stated is not None:
            points = solid.points
            if len(substances) > 1:
                points = np.concatenate([mass_inputs.meshes[i].points for i in substance.meshes])
            if not exact:
                stated = replace(
                    stated, centre=None, inertia=None
                )  # Without exact volumes there is nothing to check them against.
            result = check_statement(stated, points, volume, exact=exact and sure)
            checked.append(result)
            substance, squeeze = replace(substance, stated=result.stated), result.squeeze
        weighed = _weighed(substance, volume, squeeze)
        parts.append(SubstanceBody(substance, volume, weighed, alternative, volumes.reason, squeeze))
    return parts, exact, checked


def _sized(substances: Sequence[Substance], solid: Solid, dense_reason: str) -> tuple[Substance, ...]:
    """The substances, unknown ones as dense as things of the size of `solid` are."""
    density = unknown_density(solid, dense_reason)
    return tuple(
        replace(s, density_kgm3=density)
        if density is not None and s.material.value == UNKNOWN and s.density_kgm3.source == "default"
        else s
        for s in substances
    )


def _weighed(substance: Substance, volume: VolumeProperties, squeeze: FloatArray | None) -> MassProperties:
    """`volume` as heavy as the source states, with its mass centre and tensor if stated, else as dense as known."""
    stated = substance.stated
    if stated is None or stated.mass_kg is None:
        return volume.filled(substance.density_kgm3.value)
    body = volume.filled(stated.mass_kg / volume.volume_m3)
    if squeeze is not None:
        body = replace(body, inertia_kgm2=contracted_inertia(body.inertia_kgm2, squeeze))
    return MassProperties(
        stated.mass_kg,
        body.centre_of_mass_m if stated.centre is None else stated.centre,
        body.inertia_kgm2 if stated.inertia is None else stated.inertia,
    )
