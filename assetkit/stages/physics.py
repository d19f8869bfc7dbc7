"""Stage 6, physics: collision, mass, inertia and contact material of the physical surface."""

from __future__ import annotations

from assetkit.annotate.name_reading import category_called
from assetkit.mass.parts import Clues
from assetkit.mass.source_inertials import in_asset_frame
from assetkit.mass.unknown_density import dense_look
from assetkit.materials.part_materials import face_materials
from assetkit.physics.build import build_physics
from assetkit.stage import Canonical, Draft, Physics, Stage, Tools, need
from schemas.evidence import Evidence
from schemas.model import IntArray
from schemas.outcome import Outcome
from usdio.write.meshes import mesh_prim_names


class AuthorPhysics(Stage):
    """Chooses collision shapes by measured fidelity and derives mass properties from the solid."""

    name = "physics"
    version = 8
    result = Physics

    def run(self, draft: Draft, tools: Tools) -> Outcome[Physics]:
        """Shapes, mass and contact in the asset frame; colliders that failed acceptance are left out."""
        canonical: Canonical = need(draft.canonicalize, "canonicalize")
        folder = tools.work_dir / "physics"
        folder.mkdir(parents=True, exist_ok=True)
        built = build_physics(
            canonical.solid,
            [draft.source_name],
            work_dir=folder,
            exclude=frozenset(draft.excluded_colliders),
            clues=clues_of(draft, canonical),
            contacts=draft.intake.model.contacts,
            cavities=draft.interaction.cavities if draft.interaction else None,
        )
        physics = Physics(built.shapes, built.mass, built.contact, built.section, built.surfaces, built.shape_surfaces)
        return Outcome(physics, built.diagnostics, built.repairs, review=built.section.stands_in)


def clues_of(draft: Draft, canonical: Canonical) -> Clues:
    """What is known about the parts of the object and their masses, in its asset frame."""
    R_AM, origin_m = canonical.R_AS, canonical.section.origin_offset_m
    scale = canonical.meters_per_unit.value
    section = draft.semantics.section if draft.semantics else None
    category = category_called(section.category.value) if section else None
    touch, of_face = _touch(draft, canonical)
    return Clues(
        meshes=canonical.meshes,
        as_read=draft.intake.model.meshes,
        render_materials=tuple(m.name for m in draft.model.materials),
        masses=tuple(in_asset_frame(stated, R_AM, scale, origin_m) for stated in draft.intake.model.masses),
        unit=canonical.meters_per_unit,
        wall=canonical.section.wall_thickness_m,
        dense=dense_look(draft.intake.format, canonical.meshes, draft.model.materials),
        category=category.id if category else "",
        usual_kg=category.mass_kg if category else None,
        category_confidence=section.category.confidence if section else 0.0,
        names=(section.name, *draft.intake.folders, *section.source_texts) if section else (),
        touch=touch,
        of_face=of_face,
    )


def _touch(draft: Draft, canonical: Canonical) -> tuple[tuple[Evidence[str], ...], tuple[IntArray, ...]]:
    """Materials of the visible surface and per mesh those of its triangles; none before the interaction stage."""
    if draft.interaction is None:
        return (), ()
    meshes = dict(zip(mesh_prim_names(draft.model), canonical.meshes, strict=True))
    return face_materials(meshes, draft.interaction.parts, draft.interaction.material)
