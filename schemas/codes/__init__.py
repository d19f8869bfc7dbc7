"""Every diagnostic code but those of the gate, whose rules declare their own, in one explicit table. Each has a page
under `docs/diagnostics/` made from its row (`make docs`) and a smallest bad input in `tests/support/bad_inputs/`; one
test proves that the three agree.

A code names the pattern found, never the remedy. Codes are stable: extend, never rename.
"""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo
from schemas.codes.gap import GAP_CODES
from schemas.codes.gate import GATE_CODES
from schemas.codes.intake import INTAKE_CODES
from schemas.codes.joints import JOINT_CODES
from schemas.codes.pipeline import PIPELINE_CODES
from schemas.codes.plan import PLAN_CODES
from schemas.codes.replay import REPLAY_CODES
from schemas.codes.robot import ROBOT_CODES
from schemas.codes.scene import SCENE_CODES
from schemas.codes.scene_groups import SCENE_GROUP_CODES
from schemas.codes.shape import SHAPE_CODES
from schemas.codes.suites import SUITE_CODES
from schemas.codes.task import TASK_CODES
from schemas.codes.use import USE_CODES

CODES: dict[str, CodeInfo] = {
    **INTAKE_CODES,
    **SHAPE_CODES,
    **USE_CODES,
    **JOINT_CODES,
    **SUITE_CODES,
    **GATE_CODES,
    **GAP_CODES,
    **SCENE_CODES,
    **SCENE_GROUP_CODES,
    **PLAN_CODES,
    **REPLAY_CODES,
    **ROBOT_CODES,
    **TASK_CODES,
    **PIPELINE_CODES,
}
