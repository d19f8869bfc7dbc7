"""Rule: the asset is self-contained: relative paths that stay in the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Location, finding

CODE = DiagnosticCode(
    "asset/gate-outside-file",
    "A file lies outside the package",
    "Whoever receives the folder does not receive that file.",
    "copy the file into the package and name it by a relative path",
)
_ABSOLUTE = re.compile(r"^(/|\\|[A-Za-z]:[\\/]|[A-Za-z][A-Za-z0-9+.-]+://)")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per path that is absolute or a network address, and in a package per file outside its folder."""
    package = subject.package_folder if subject.released else None
    for where, path, resolved in _named(subject):
        if _ABSOLUTE.match(path):
            headline = "a file is named by an absolute path or address"
            yield finding(CODE, headline, where=where, value=path, severity=subject.suspect_severity)
        elif package is not None and resolved and not Path(resolved).resolve().is_relative_to(package):
            yield finding(CODE, "a file lies outside the package", where=where, value=path)


def _named(subject: Subject) -> Iterator[tuple[Location, str, str]]:
    """Where, path as authored, and the file it resolves to or ""."""
    for layer in subject.stage.GetUsedLayers():
        if layer.anonymous:
            continue
        for path in filter(None, layer.GetCompositionAssetDependencies()):  # An internal reference names no file.
            where = Location(file=Path(layer.realPath).name)
            yield where, path, str(Ar.GetResolver().Resolve(Sdf.ComputeAssetPathRelativeToLayer(layer, path)))
    for attribute in subject.attributes:
        value: Any = attribute.Get(TIME) if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset else None
        if value is not None and value.path:
            inside_archive = Ar.IsPackageRelativePath(value.resolvedPath)
            yield at(attribute.GetPrim()), value.path, "" if inside_archive else value.resolvedPath


RULE = Rule(CODE, "relative paths that stay in the package", "SimReady AA.001, AA.002", check)
