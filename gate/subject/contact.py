"""Contact materials bound to collider prims, as OpenUSD resolves the bindings."""

from __future__ import annotations

from typing import Any

from pxr import UsdPhysics, UsdShade


def bound_material(prim: Any) -> Any | None:
    """The Material prim bound to a collider for purpose `physics`, else for all purposes; None without one."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    return material.GetPrim() if material and material.GetPrim() else None


def contact_material(prim: Any) -> Any | None:
    """The bound material if it has physics properties."""
    material = bound_material(prim)
    return material if material is not None and material.HasAPI(UsdPhysics.MaterialAPI) else None
