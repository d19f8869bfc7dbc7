"""The contact material of a collider prim, as OpenUSD resolves its material bindings."""

from __future__ import annotations

from pxr import Usd, UsdPhysics, UsdShade


def bound_contact_material(prim: Usd.Prim) -> UsdPhysics.MaterialAPI | None:
    """The contact material of a collider (purpose `physics`, else the all-purpose one), or None."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    return UsdPhysics.MaterialAPI(material.GetPrim()) if material and material.GetPrim() else None
