"""All seeded defects, and edits that are none, by rule group: asset, bodies, colliders, joints, visual surfaces."""

from tests.suites.gate.defects import asset, body, collider, joint, visual
from tests.suites.gate.edits import Defect, Sound

DEFECTS: tuple[Defect, ...] = (
    *asset.DEFECTS,
    *body.DEFECTS,
    *collider.DEFECTS,
    *joint.DEFECTS,
    *visual.DEFECTS,
)
SOUND: tuple[Sound, ...] = (
    *asset.SOUND,
    *body.SOUND,
    *collider.SOUND,
    *joint.SOUND,
    *visual.SOUND,
)
