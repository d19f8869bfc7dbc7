"""Every diagnostic code, in one explicit table. Each has a page under `docs/diagnostics/` made from its row
(`python -m cli.docs`) and a smallest bad input in `tests/bad_inputs.py`; one test proves that the three agree.

A code names the pattern found, never the remedy. Codes are stable: extend, never rename.
"""

from __future__ import annotations

from schemas.code_info import CodeInfo
from schemas.gap_codes import GAP_CODES
from schemas.gate_codes import GATE_CODES
from schemas.intake_codes import INTAKE_CODES
from schemas.plan_codes import PLAN_CODES
from schemas.replay_codes import REPLAY_CODES
from schemas.scene_codes import SCENE_CODES
from schemas.shape_codes import SHAPE_CODES
from schemas.use_codes import USE_CODES

CODES: dict[str, CodeInfo] = {
    **INTAKE_CODES,
    **SHAPE_CODES,
    **USE_CODES,
    **GATE_CODES,
    **GAP_CODES,
    **SCENE_CODES,
    **PLAN_CODES,
    **REPLAY_CODES,
}
