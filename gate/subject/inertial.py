"""Mass centre (m) and inertia (kg m2) of a body as authored, and whether its surfaces share one material."""

from __future__ import annotations

import numpy as np
from pxr import UsdGeom, UsdShade

from gate.subject.body import Body
from gate.subject.subject import Subject
from gate.subject.values import quaternion, vector
from geom.mass.principal_axes import inertia_from_principal
from schemas.arrays import FloatArray


def stated_inertia(body: Body, subject: Subject) -> FloatArray | None:
    """(3, 3) the stated tensor in kg m2 along the body's axes, or None when invalid (reported by the inertia rule)."""
    moments = vector(body.prim, "physics:diagonalInertia", (0.0, 0.0, 0.0))
    quat_wxyz = quaternion(body.prim, "physics:principalAxes")
    if not (np.all(moments > 0.0) and np.all(np.isfinite(moments)) and np.all(np.isfinite(quat_wxyz))):
        return None
    to_si = subject.kilograms_per_unit * subject.frames.meters_per_unit**2
    turned = quat_wxyz if np.any(quat_wxyz) else np.array([1.0, 0.0, 0.0, 0.0])
    return inertia_from_principal(moments * to_si, turned)


def mass_centre(body: Body, subject: Subject) -> FloatArray | None:
    """(3,) the stated mass centre in the body frame, metres; None when it is left to the engine or not finite."""
    centre = vector(body.prim, "physics:centerOfMass", (np.nan,) * 3)
    if not np.all(np.isfinite(centre)):
        return None
    matrix = subject.frames.matrix(body.prim)
    return body.in_body((matrix[:3, :3] @ centre + matrix[:3, 3])[None])[0]


def shows_one_material(body: Body) -> bool:
    """True iff all visible surfaces of a body are bound to one material, which suggests even density."""
    paths = {path for surface in body.surfaces for path in _bound_material_paths(surface.prim)}
    return len(paths) == 1


def _bound_material_paths(prim: UsdGeom.Imageable) -> set[str]:
    """Paths of the materials bound to a mesh and its subsets; "" for none."""
    prims = [prim]
    if prim.IsA(UsdGeom.Mesh):
        prims += [subset.GetPrim() for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
    bound = [UsdShade.MaterialBindingAPI(p).ComputeBoundMaterial()[0] for p in prims]
    return {str(material.GetPath()) if material else "" for material in bound}
