"""Stage 6, physics: collision, mass, inertia and contact material of the physical surface."""

from __future__ import annotations

from assetkit.stage import Canonical, Draft, Physics, Tools, need
from assetkit.stages.physics import build_physics
from schemas.diagnostics import Diagnostic
from schemas.outcome import Outcome


class AuthorPhysics:
    """Chooses collision shapes by measured fidelity and derives mass properties from the solid."""

    name = "physics"
    version = 1
    result = Physics

    def accepts(self, draft: Draft) -> list[Diagnostic]:
        """Nothing forbids running: canonicalize always yields a solid."""
        return []

    def run(self, draft: Draft, tools: Tools) -> Outcome[Physics]:
        """Shapes, mass and contact in the asset frame; colliders that failed acceptance are left out."""
        canonical: Canonical = need(draft.canonicalize, "canonicalize")
        names = [draft.source_name, *(m.name for m in draft.model.materials), *(m.name for m in canonical.meshes)]
        folder = tools.work_dir / "physics"
        folder.mkdir(parents=True, exist_ok=True)
        built = build_physics(canonical.solid, names, work_dir=folder, exclude=frozenset(draft.excluded_colliders))
        physics = Physics(built.shapes, built.mass, built.contact, built.section)
        return Outcome(physics, built.diagnostics, built.repairs)
