"""Stage 6, physics: collision, mass, inertia and contact material of the physical surface."""

from __future__ import annotations

from assetkit.mass_parts import Clues
from assetkit.source_inertials import in_asset_frame
from assetkit.stage import Canonical, Draft, Physics, Stage, Tools, need
from assetkit.stages.physics import build_physics
from assetkit.unknown_density import dense_look
from assetkit.up_axis import TO_Z_UP
from schemas.asset import PhysicsSection
from schemas.outcome import Outcome

# Beyond these (share of the diagonal; volume of the shapes over that of the solid) a stand-in goes to review.
CRUDE_P95, CRUDE_RATIO = 0.05, 2.0


class AuthorPhysics(Stage):
    """Chooses collision shapes by measured fidelity and derives mass properties from the solid."""

    name = "physics"
    version = 3
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
        )
        physics = Physics(built.shapes, built.mass, built.contact, built.section)
        return Outcome(physics, built.diagnostics, built.repairs, review=_is_crude(built.section))


def clues_of(draft: Draft, canonical: Canonical) -> Clues:
    """What is known about the parts of the object and their masses, in its asset frame."""
    R_AM, origin_m = TO_Z_UP[canonical.up_axis.value], canonical.section.origin_offset_m
    scale = canonical.meters_per_unit.value
    return Clues(
        meshes=canonical.meshes,
        as_read=draft.intake.model.meshes,
        render_materials=tuple(m.name for m in draft.model.materials),
        masses=tuple(in_asset_frame(stated, R_AM, scale, origin_m) for stated in draft.intake.model.masses),
        unit=canonical.meters_per_unit,
        wall=canonical.section.wall_thickness_m,
        dense=dense_look(draft.intake.format, canonical.meshes, draft.model.materials),
    )


def _is_crude(section: PhysicsSection) -> bool:
    """Whether the chosen collider misses the solid so far that a person should look before anyone uses it."""
    chosen = next((c for c in section.candidates if c.method == section.collision_method), None)
    if chosen is None or chosen.accepted:
        return False
    ratio = chosen.volume_ratio if chosen.volume_ratio is not None else 1.0
    far = max(chosen.outside_p95, chosen.missing_p95) > CRUDE_P95
    return far or chosen.cavity_kept is False or not 1.0 / CRUDE_RATIO <= ratio <= CRUDE_RATIO
