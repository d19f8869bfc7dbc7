"""Every diagnostic code with its meaning: the tables of `schemas.codes`, and what the rules of the gate declare."""

from __future__ import annotations

from schemas.codes import CODES
from schemas.codes.code_info import CodeInfo


def all_codes() -> dict[str, CodeInfo]:
    """The meaning of each code by its name."""
    from gate.static_gate import RULES  # Loads OpenUSD, which most commands do not need.

    return {**CODES, **{rule.code.name: rule.code.info for rule in RULES}}


def code_info(code: str) -> CodeInfo | None:
    """The meaning of one code; None where there is no such code."""
    return CODES.get(code) or all_codes().get(code)
