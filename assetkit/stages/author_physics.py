"""Stage 6, physics: collision, mass, inertia and contact material of the physical surface."""

from __future__ import annotations

from assetkit.stage import Canonical, Draft, Physics, Tools, need
from assetkit.stages.physics import build_physics
from schemas.asset import PhysicsSection
from schemas.diagnostics import Diagnostic
from schemas.outcome import Outcome

# Beyond these (share of the diagonal; volume of the shapes over that of the solid) a stand-in goes to review.
CRUDE_P95, CRUDE_RATIO = 0.05, 2.0


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
        return Outcome(physics, built.diagnostics, built.repairs, review=_is_crude(built.section))


def _is_crude(section: PhysicsSection) -> bool:
    """Whether the chosen collider misses the solid so far that a person should look before anyone uses it."""
    chosen = next((c for c in section.candidates if c.method == section.collision_method), None)
    if chosen is None or chosen.accepted:
        return False
    ratio = chosen.volume_ratio if chosen.volume_ratio is not None else 1.0
    far = max(chosen.outside_p95, chosen.missing_p95) > CRUDE_P95
    return far or chosen.cavity_kept is False or not 1.0 / CRUDE_RATIO <= ratio <= CRUDE_RATIO
