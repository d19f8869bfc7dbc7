"""Stage 6, physics: collision, mass, inertia and contact material of the physical surface."""

from __future__ import annotations

from assetkit.physics.build import build_physics
from assetkit.physics.friction_edit import with_friction
from assetkit.physics.links import link_physics
from assetkit.physics.mass_inputs import mass_inputs_of
from assetkit.stage import Appearance, Canonical, Draft, Interaction, Physics, Semantics, Stage, Tools
from schemas.outcome import Outcome


class AuthorPhysics(Stage):
    """Chooses collision shapes by measured fidelity and derives mass properties from the solid."""

    name = "physics"
    version = 12
    result = Physics
    reads = (Canonical, Appearance, Semantics, Interaction)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Physics]:
        """Shapes, mass and contact in the asset frame; colliders that failed acceptance are left out."""
        canonical = draft[Canonical]
        folder = tools.work_dir / "physics"
        folder.mkdir(parents=True, exist_ok=True)
        if canonical.mechanism is not None:
            return link_physics(
                canonical.mechanism,
                canonical.links,
                mass_inputs_of(draft, canonical),
                names=[draft.source_name],
                contacts=draft.intake.model.contacts,
                work_dir=folder,
                cavities=draft.interaction.link_cavities if draft.interaction else None,
            )
        built = build_physics(
            canonical.solid,
            [draft.source_name],
            work_dir=folder,
            exclude=frozenset(draft.edits.excluded_colliders),
            mass_inputs=mass_inputs_of(draft, canonical),
            contacts=draft.intake.model.contacts,
            cavities=draft.interaction.cavities if draft.interaction else None,
        )
        built = with_friction(built, draft.edits.friction_gain)
        physics = Physics(built.shapes, built.mass, built.contact, built.section, built.surfaces, built.shape_surfaces)
        return Outcome(physics, built.diagnostics, built.repairs, review=built.section.collider_misses_bounds)
