"""Evidence on the mass of a draft: meshes, stated masses, category, names, surface materials; asset frame, metres."""

from __future__ import annotations

from assetkit.annotate.name_reading import category_by_name
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.mass.source_inertials import in_asset_frame
from assetkit.mass.unknown_density import dense_appearance
from assetkit.materials.part_materials import face_materials
from assetkit.stage import Canonical, Draft
from schemas.arrays import IntArray
from schemas.evidence import Evidence


def mass_inputs_of(draft: Draft, canonical: Canonical) -> MassEvidenceInputs:
    """The evidence about the parts of the object and their masses, in its asset frame (metres, kg)."""
    R_AM, origin_m = canonical.R_AS, canonical.section.origin_offset_m
    scale = canonical.meters_per_unit.value
    section = draft.semantics.section if draft.semantics else None
    category = category_by_name(section.category.value) if section else None
    materials, of_face = _surface_materials(draft, canonical)
    return MassEvidenceInputs(
        meshes=canonical.meshes,
        as_read=draft.intake.model.meshes,
        render_materials=tuple(m.name for m in draft.model.materials),
        masses=tuple(in_asset_frame(stated, R_AM, scale, origin_m) for stated in draft.intake.model.masses),
        unit=canonical.meters_per_unit,
        wall=canonical.section.wall_thickness_m,
        dense_reason=dense_appearance(draft.intake.format, canonical.meshes, draft.model.materials),
        category=category.id if category else "",
        category_range_kg=category.mass_kg if category else None,
        category_confidence=section.category.confidence if section else 0.0,
        names=(section.name, *draft.intake.folders, *section.source_texts) if section else (),
        surface_materials=materials,
        material_of_face=of_face,
    )


def _surface_materials(draft: Draft, canonical: Canonical) -> tuple[tuple[Evidence[str], ...], tuple[IntArray, ...]]:
    """Materials of the visible surface and per mesh those of its triangles; none before the interaction stage."""
    if draft.interaction is None:
        return (), ()
    return face_materials(draft.model.meshes_by_id, draft.interaction.parts, draft.interaction.material)
