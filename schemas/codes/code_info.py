"""What a diagnostic code means: severity, title, reason and help, in a table of codes or beside the check itself."""

from __future__ import annotations

from typing import Literal, NamedTuple

CodeSeverity = Literal["error", "warning", "info"]


class CodeInfo(NamedTuple):
    """What one code means: its default severity, one-line title, why it matters and what to do."""

    severity: CodeSeverity
    title: str
    why: str
    help: str


class DiagnosticCode(NamedTuple):
    """A code with its meaning, declared by the one check that reports it; codes of several places are in the tables."""

    name: str
    title: str
    why: str
    help: str
    severity: CodeSeverity = "error"

    @property
    def info(self) -> CodeInfo:
        """The meaning as a row of a table."""
        return CodeInfo(self.severity, self.title, self.why, self.help)
