"""Diagnostics are data; only `cli` turns them into text.

InvalidInput            raised inside a reader to stop at a fatal finding; carries the Diagnostic.
                        Stages catch it at their border and return it as data.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from enum import StrEnum
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict

from schemas.codes import CODES
from schemas.codes.code_info import DiagnosticCode


def printable(text: str) -> str:
    """`text` as it can be printed and stored anywhere: control, format and lone surrogate characters become escapes.

    Names in files are not ours: they may hold escape sequences of terminals, line breaks, or bytes that are no text.
    """
    if text.isprintable():
        return text
    blanks = {c for c in text if unicodedata.category(c) == "Zs"}
    return "".join(c if c.isprintable() or c in blanks else repr(c)[1:-1] for c in text)


PrintableText = Annotated[str, AfterValidator(printable)]


class Severity(StrEnum):
    """How much a finding matters: an `error` rejects the item, a `warning` or `info` does not."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


class Location(BaseModel):
    """Where something was found. `file` is relative to the asset's root, never absolute."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    file: PrintableText | None = None
    line: int | None = None
    column: int | None = None
    prim: PrintableText | None = None
    mesh: PrintableText | None = None

    def __str__(self) -> str:
        position = ":".join(str(p) for p in (self.file, self.line, self.column) if p is not None)
        return " ".join(p for p in (position, self.prim, self.mesh) if p) or "(whole asset)"


class Label(BaseModel):
    """A remark on a second location."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    where: Location
    text: PrintableText


class Diagnostic(BaseModel):
    """One finding: what, where, the value against the bound with units, and what to do.

    `value` and `bound` are in `unit`. `because` is the cause tree, nearest cause first.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    code: str
    severity: Severity
    headline: PrintableText
    where: Location = Location()
    value: float | PrintableText | None = None
    bound: float | PrintableText | None = None
    unit: str = ""
    labels: tuple[Label, ...] = ()
    because: tuple[Diagnostic, ...] = ()
    help: str = ""


class InvalidInput(Exception):
    """The user's file cannot be used; `diagnostic` gives the reason."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.headline)
        self.diagnostic = diagnostic


def any_error(diagnostics: Iterable[Diagnostic]) -> bool:
    """Whether one of them is an error."""
    return any(d.severity is Severity.ERROR for d in diagnostics)


def finding(
    code: str | DiagnosticCode,
    headline: str,
    *,
    where: Location | None = None,
    value: float | str | None = None,
    bound: float | str | None = None,
    unit: str = "",
    labels: tuple[Label, ...] = (),
    because: tuple[Diagnostic, ...] = (),
    severity: Severity | None = None,
) -> Diagnostic:
    """A diagnostic with the severity and help of its code: of the one given, or of the entry in `schemas.codes`.

    Raises KeyError for an unknown name, so that a code cannot exist without its page.
    """
    name, info = (code.name, code.info) if isinstance(code, DiagnosticCode) else (code, CODES[code])
    return Diagnostic(
        code=name,
        severity=severity or Severity(info.severity),
        headline=headline,
        where=where or Location(),
        value=value,
        bound=bound,
        unit=unit,
        labels=labels,
        because=because,
        help=info.help,
    )
