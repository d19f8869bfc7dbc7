"""Rule: a token attribute holds one of the tokens that its schema allows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Sdf

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-unknown-token",
    "An attribute has a value that its schema does not know",
    "Each reader falls back to something else.",
    "use one of the tokens named",
)
# Vocabularies that engines extend in schemas of their own.
EXTENDED = {"physics:approximation": ("sdf", "sphereFill")}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per attribute whose schema lists the allowed tokens and whose value is none of them.

    Readers differ on unknown tokens: an unknown purpose is drawn by one and hidden by the next.
    """
    for attribute in subject.attributes:
        if attribute.GetTypeName() != Sdf.ValueTypeNames.Token:
            continue
        stated: Any = attribute.GetMetadata("allowedTokens")
        allowed = tuple(stated) if stated else ()
        value, name = attribute.Get(TIME), attribute.GetName()
        if allowed and value is not None and value not in (*allowed, *EXTENDED.get(name, ())):
            where, bound = at(attribute.GetPrim()), ", ".join(allowed)
            yield finding(CODE, f"{name} has an unknown value", where=where, value=str(value), bound=bound)


RULE = Rule(CODE, "one of the tokens that the schema allows", "allowedTokens of the USD schemas", check)
