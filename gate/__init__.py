"""Static gate: plausibility rules over released USD packages (`static_gate`), and external validators of them."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from gate.external_validators import external_verdicts
    from gate.static_gate import RULES, gate

__all__ = ["RULES", "external_verdicts", "gate"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "RULES": "gate.static_gate",
        "external_verdicts": "gate.external_validators",
        "gate": "gate.static_gate",
    },
)
