"""Rule: every file that the asset refers to exists."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pxr import Sdf, UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Location, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-missing-file",
    "A file the package names is absent",
    "The surface loses its picture, or the asset a part, on every machine but, at best, one.",
    "put the file into the package and name it by a relative path",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per layer that composition cannot open and per asset-valued attribute whose path leads nowhere."""
    for error in subject.stage.GetCompositionErrors():
        where, text = Location(prim=str(error.rootSite.path)), _shortened(str(error), subject.main_file)
        # The usd-core wheel brings no MaterialX plugin: such a layer may be sound and is merely unread here.
        unread = "Cannot determine file format" in text
        headline = "a layer is of a kind not read here" if unread else "a layer cannot be composed"
        severity = Severity.WARNING if unread else Severity.ERROR
        yield finding(CODE, headline, where=where, value=text, severity=severity)
    for attribute in subject.attributes:
        if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset:
            value = attribute.Get(TIME)
            if value is not None and value.path and not _found(value, subject):
                where = at(attribute.GetPrim())
                yield finding(CODE, "a file is missing", where=where, value=value.path)


def _found(value: Any, subject: Subject) -> bool:
    if value.resolvedPath or _is_engine_module(value.path):
        return True
    tiles = UsdShade.UdimUtils
    return tiles.IsUdimIdentifier(value.path) and bool(
        tiles.ResolveUdimTilePaths(value.path, subject.stage.GetRootLayer())
    )


def _shortened(text: str, main_file: Path) -> str:
    """A message of OpenUSD without the folders it names."""
    for folder in (main_file.resolve().parent, main_file.parent):
        text = text.replace(f"{folder}/", "")
    return " ".join(text.split())[:300]


def _is_engine_module(path: str) -> bool:
    """An MDL module named without a folder is found on the renderer's own search path, never beside the asset."""
    return path.endswith(".mdl") and "/" not in path


RULE = Rule(CODE, "every path resolves", "SimReady AA.001; OpenUSD asset resolution", check)
