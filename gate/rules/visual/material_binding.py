"""Rule: material bindings lead to materials."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import UsdGeom, UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-material-binding",
    "A material binding leads to no material",
    "The surface is drawn grey, or the contact uses defaults.",
    "bind an existing Material prim",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per binding to a prim that is absent or no Material, per unapplied binding API, and per visible mesh
    of a package without any material.
    """
    unread = bool(subject.stage.GetCompositionErrors())  # Composition errors are reported by the missing-file rule.
    for prim in subject.prims:
        if prim.IsInstanceProxy():
            continue
        for relationship in prim.GetAuthoredRelationships():
            name = relationship.GetName()
            if name == "material:binding" or (name.startswith("material:binding:") and ":collection:" not in name):
                for target in relationship.GetForwardedTargets():
                    bound = subject.stage.GetPrimAtPath(target)
                    if not bound and unread:
                        continue
                    if not bound or not bound.IsA(UsdShade.Material):
                        headline = "the binding leads to nothing" if not bound else "the binding leads to no material"
                        yield finding(CODE, headline, where=at(prim), value=str(target))
    if not subject.released:
        return
    for prim in subject.visible_prims:
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if not material and not (_subsets(prim)):
            yield finding(CODE, "the visible mesh has no material", where=at(prim), severity=Severity.ERROR)


def _subsets(prim: UsdGeom.Mesh) -> bool:
    return prim.IsA(UsdGeom.Mesh) and bool(UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets())


RULE = Rule(
    CODE, "an existing Material; one for every visible mesh", "UsdShadeMaterialBindingAPI; SimReady VM.BIND.001", check
)
