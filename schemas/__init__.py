"""Data that crosses a package border or the disk: models, evidence, diagnostics. Standard library, pydantic, numpy."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from schemas.asset import AssetRecord
    from schemas.codes import CODES
    from schemas.diagnostics import Diagnostic, InvalidInput, Severity
    from schemas.evidence import Evidence
    from schemas.outcome import ItemOutcome
    from schemas.report import IngestReport
    from schemas.scene.program import SceneProgram
    from schemas.scene.runtime_plan import RuntimePlan
    from schemas.sim_gap.extension import ModelExtension
    from schemas.sim_gap.report import GapReport

__all__ = [
    "CODES",
    "AssetRecord",
    "Diagnostic",
    "Evidence",
    "GapReport",
    "IngestReport",
    "InvalidInput",
    "ItemOutcome",
    "ModelExtension",
    "RuntimePlan",
    "SceneProgram",
    "Severity",
]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "AssetRecord": "schemas.asset",
        "CODES": "schemas.codes",
        "Diagnostic": "schemas.diagnostics",
        "Evidence": "schemas.evidence",
        "GapReport": "schemas.sim_gap.report",
        "IngestReport": "schemas.report",
        "InvalidInput": "schemas.diagnostics",
        "ItemOutcome": "schemas.outcome",
        "ModelExtension": "schemas.sim_gap.extension",
        "RuntimePlan": "schemas.scene.runtime_plan",
        "SceneProgram": "schemas.scene.program",
        "Severity": "schemas.diagnostics",
    },
)
