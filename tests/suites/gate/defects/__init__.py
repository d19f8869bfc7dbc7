"""All seeded defects by the rule group they concern: asset, bodies, colliders, joints, visual surfaces."""

from tests.suites.gate.defects import asset, body, collider, joint, visual
from tests.suites.gate.edits import Defect

DEFECTS: tuple[Defect, ...] = (
    *asset.DEFECTS,
    *body.DEFECTS,
    *collider.DEFECTS,
    *joint.DEFECTS,
    *visual.DEFECTS,
)
