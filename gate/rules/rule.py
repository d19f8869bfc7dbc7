"""The data of one gate rule: code, bound, source of the bound, and the check function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from gate.subject import Subject
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic


class Rule(NamedTuple):
    """A rule as data: the code it reports, what passes, where the bound comes from, and the check itself.

    The code brings title, reason and remedy. `docs/reference/gate.md` and a page per code are made from the rules.
    """

    code: DiagnosticCode
    bound: str
    source: str
    check: Callable[[Subject], Iterator[Diagnostic]]
