"""The data of one gate rule: code, bound, source of the bound, and the check function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from gate.subject import Subject
from schemas.diagnostics import Diagnostic


class Rule(NamedTuple):
    """A rule as data: the code it reports, what passes, where the bound comes from, and the check itself.

    Title, reason and remedy are those of the code in `schemas.codes.gate`. `docs/reference/gate.md` is made from both.
    """

    code: str
    bound: str
    source: str
    check: Callable[[Subject], Iterator[Diagnostic]]
