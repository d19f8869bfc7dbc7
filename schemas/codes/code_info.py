"""One row of the tables of diagnostic codes: severity, title, reason and help."""

from __future__ import annotations

from typing import Literal, NamedTuple


class CodeInfo(NamedTuple):
    """What one code means: its default severity, one-line title, why it matters and what to do."""

    severity: Literal["error", "warning", "info"]
    title: str
    why: str
    help: str
