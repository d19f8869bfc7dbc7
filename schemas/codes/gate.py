"""Codes of outside validators, as `mana assets validate` reports them; part of `schemas.codes`.

The codes of the static gate are declared by its rules (`gate.rules`), one per file.
"""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

GATE_CODES: dict[str, CodeInfo] = {
    "asset/simready-rule": CodeInfo(
        "error",
        "SimReady Foundation refuses something",
        "Isaac Sim and its kin take packages that pass its profile; a file that claims nothing may ignore it.",
        "see the requirement named in the SimReady Foundation documentation",
    ),
    "asset/usd-rule": CodeInfo(
        "error",
        "OpenUSD's own validators refuse something",
        "The file breaks a rule of a USD schema, so readers will disagree about it.",
        "see the validator named in the OpenUSD documentation",
    ),
}
