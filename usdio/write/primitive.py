"""Authors an inline primitive of a scene (box, cylinder, sphere); one prim is both visual and collider."""

from __future__ import annotations

import numpy as np
from PIL import ImageColor
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from geom.mass.inertia import moved, of_box, of_cylinder, of_sphere, scaled
from geom.pose import pose
from schemas.physics import Contact, MassProperties
from schemas.scene.program import BoxAsset, CylinderAsset, Inline
from usdio.write.physics import author_body

DENSITY_KGM3 = 500.0  # Of wood and filled boxes; used only where the program states no mass.
CONTACT = Contact(static_friction=0.6, dynamic_friction=0.5, restitution=0.1)
_GREY = "#b8bdc4"


def author_primitive(
    stage: Usd.Stage,
    path: Sdf.Path,
    primitive: Inline,
    scale: float,
    mass_kg: float | None,
    contact: Sdf.Path,
    *,
    moves: bool,
) -> None:
    """Body, mass and `<path>/Shape` of a box, cylinder or sphere whose frame has its origin at the bottom centre.

    Sizes are multiplied by `scale`; `mass_kg` is that of the result, by default its volume at 500 kg/m3.
    """
    shape = _define(stage, path.AppendChild("Shape"), primitive, scale)
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim()).CreateCollisionEnabledAttr(True)
    binding = UsdShade.MaterialBindingAPI.Apply(shape.GetPrim())
    binding.Bind(UsdShade.Material.Get(stage, contact), materialPurpose="physics")
    shape.CreateDisplayColorAttr([Gf.Vec3f(*_linear_rgb(primitive.color or _GREY))])
    if moves:
        author_body(stage.GetPrimAtPath(path), primitive_mass(primitive, scale, mass_kg))


def primitive_mass(primitive: Inline, scale: float, mass_kg: float | None) -> MassProperties:
    """Mass properties in the frame of the primitive, origin at the bottom centre."""
    if isinstance(primitive, BoxAsset):
        x, y, z = (scale * edge for edge in primitive.size_m)
        solid, middle_m = of_box((x, y, z), DENSITY_KGM3), z / 2.0
    elif isinstance(primitive, CylinderAsset):
        height_m = scale * primitive.height_m
        solid, middle_m = of_cylinder(scale * primitive.radius_m, height_m, DENSITY_KGM3), height_m / 2.0
    else:
        middle_m = scale * primitive.radius_m
        solid = of_sphere(middle_m, DENSITY_KGM3)
    body = solid if mass_kg is None else scaled(solid, mass_kg / solid.mass_kg)
    return moved(body, pose(None, (0.0, 0.0, middle_m)))


def _define(stage: Usd.Stage, path: Sdf.Path, primitive: Inline, scale: float) -> UsdGeom.Gprim:
    """The shape itself, posed so that its lowest point is the origin of the body."""
    edges = np.ones(3)
    if isinstance(primitive, BoxAsset):
        gprim = UsdGeom.Cube.Define(stage, path)
        gprim.CreateSizeAttr(1.0)
        edges = scale * np.array(primitive.size_m)
        middle_m = float(edges[2]) / 2.0
    elif isinstance(primitive, CylinderAsset):
        gprim = UsdGeom.Cylinder.Define(stage, path)
        gprim.CreateAxisAttr(UsdGeom.Tokens.z)
        gprim.CreateRadiusAttr(scale * primitive.radius_m)
        gprim.CreateHeightAttr(scale * primitive.height_m)
        middle_m = scale * primitive.height_m / 2.0
    else:
        gprim = UsdGeom.Sphere.Define(stage, path)
        gprim.CreateRadiusAttr(scale * primitive.radius_m)
        middle_m = scale * primitive.radius_m
    gprim.CreateExtentAttr(UsdGeom.Boundable.ComputeExtentFromPlugins(gprim, Usd.TimeCode.Default()))
    gprim.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(0.0, 0.0, middle_m))
    if isinstance(primitive, BoxAsset):
        gprim.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*edges.tolist()))
    return gprim


def _linear_rgb(color: str) -> tuple[float, float, float]:
    """Linear RGB of a CSS colour, the space of `displayColor`; grey when it is not valid."""
    try:
        red, green, blue, *_ = ImageColor.getrgb(color)
    except ValueError:
        red, green, blue, *_ = ImageColor.getrgb(_GREY)
    encoded = np.array([red, green, blue]) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return tuple(linear.tolist())
