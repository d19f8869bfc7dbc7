"""Collision shapes of USD that Mana did not write: the convex shapes that an engine makes of a collider prim.

UsdPhysics leaves it to `physics:approximation` what becomes of a mesh. What is changed or assumed is noted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from geom.convex.hull import MAX_POINTS, convex_hull, hull_shape, volume
from geom.convex.primitive_fits import fit_box
from geom.decomposition.decompose import convex_parts
from geom.decomposition.simplified_body import simplify_body
from geom.mesh.weld import weld_points
from geom.pose import apply, pose, shortest_rotation
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.physics import CollisionShape
from usdio.read.gprim_mesh import GprimMesh
from usdio.read.meshes import IMPLICIT_SHAPES, read_implicit_shape, read_mesh

# Of edges or of axes of a transform: what single precision leaves between equal ones.
EVEN: Final = 1e-4
# Of the volume: a closed surface this near to the volume of its hull is convex, whatever its approximation says.
CONVEX_SHARE: Final = 0.999
_AXES: Final = {"X": np.array([1.0, 0.0, 0.0]), "Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}
Note = Callable[[Diagnostic], None]


def foreign_shapes(prim: Usd.Prim, X_AP: FloatArray, where: Location, note: Note) -> tuple[CollisionShape, ...]:
    """The convex shapes of one collider prim whose affine placement is `X_AP` (4, 4), scale included.

    Cubes, balls, cylinders and capsules stay what they are; where their transform stretches them unevenly, and for
    other shapes of UsdGeom, the hull of the surface is taken. Of meshes `physics:approximation` decides. Raises
    InvalidInput: `asset/foreign-unsupported` for what no engine takes as convex shapes, and as
    `usdio.read.meshes.read_mesh` for broken arrays.
    """
    if prim.IsA(UsdGeom.Mesh):
        surface = read_mesh(prim, where).value
        if surface is None:
            raise unsupported("a collider mesh without faces", where)
        return _of_mesh(prim, _placed(surface, X_AP), where, note)
    if str(prim.GetTypeName()) not in IMPLICIT_SHAPES:
        raise unsupported(f"a collider of type '{prim.GetTypeName()}'", where)
    shape = _primitive(prim, X_AP)
    if shape is not None:
        return (shape,)
    surface = read_implicit_shape(prim, where).value
    if surface is None:
        raise unsupported("a collider of size zero", where)
    note(_converted(f"the {prim.GetTypeName()} '{prim.GetName()}' became the hull of its surface", where))
    return (_hull(_placed(surface, X_AP)[0], where),)


def placed_surface(prim: Usd.Prim, X_AP: FloatArray, where: Location) -> tuple[FloatArray, IntArray] | None:
    """Points (n, 3) and triangles (m, 3) of a mesh or implicit shape placed by `X_AP`; None without faces."""
    read = read_mesh if prim.IsA(UsdGeom.Mesh) else read_implicit_shape
    surface = read(prim, where).value
    return None if surface is None else _placed(surface, X_AP)


def unsupported(content: str, where: Location) -> InvalidInput:
    """The error for what acceptance cannot exercise."""
    return InvalidInput(finding("asset/foreign-unsupported", f"the package holds {content}", where=where))


def _placed(surface: GprimMesh, X_AP: FloatArray) -> tuple[FloatArray, IntArray]:
    """Points and outward triangles after a transform, which may mirror."""
    triangles = np.asarray(surface.triangles, dtype=np.int32)
    mirrored = np.linalg.det(X_AP[:3, :3]) < 0.0
    return apply(X_AP, surface.points), triangles[:, ::-1] if mirrored else triangles


def _of_mesh(
    prim: Usd.Prim, surface: tuple[FloatArray, IntArray], where: Location, note: Note
) -> tuple[CollisionShape, ...]:
    points, triangles = surface
    authored = prim.GetAttribute("physics:approximation")
    way = str(authored.Get() or "none") if authored else "none"
    if way == UsdPhysics.Tokens.boundingCube:
        box = fit_box(points)
        if box is None:
            raise unsupported("a flat collider mesh to be put in a box", where)
        note(_converted(f"the collider '{prim.GetName()}' became its bounding box (boundingCube)", where))
        return (box,)
    if way == UsdPhysics.Tokens.boundingSphere:
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(points - middle, axis=1).max())
        note(_converted(f"the collider '{prim.GetName()}' became a ball about its box (boundingSphere)", where))
        return (CollisionShape("sphere", (radius,), pose(None, middle)),)
    if way == UsdPhysics.Tokens.convexHull or _is_convex(points, triangles):
        return (_hull_of_mesh(prim, points, triangles, where, note),)
    if way == UsdPhysics.Tokens.convexDecomposition:
        return _decomposed(prim, points, triangles, where, note)
    raise unsupported(f"a moving collider mesh that is not convex, with approximation '{way}'", where)


def _hull_of_mesh(
    prim: Usd.Prim, points: FloatArray, triangles: IntArray, where: Location, note: Note
) -> CollisionShape:
    """The mesh as it is where it is a hull of triangles already, else the hull of its points, reduced."""
    if _is_convex(points, triangles) and len(points) <= MAX_POINTS and len(np.unique(triangles)) == len(points):
        return CollisionShape("hull", (), np.eye(4), points, triangles)
    shape = _hull(points, where)
    corners = 0 if shape.points is None else len(shape.points)
    headline = f"the collider '{prim.GetName()}' of {len(points)} points became their hull of {corners} points"
    note(_converted(headline, where))
    return shape


def _decomposed(
    prim: Usd.Prim, points: FloatArray, triangles: IntArray, where: Location, note: Note
) -> tuple[CollisionShape, ...]:
    welded = weld_points(points, triangles)
    try:
        body = simplify_body(*welded)
    except ValueError as reason:
        raise unsupported(f"a collider mesh that cannot be decomposed into convex parts: {reason}", where) from reason
    parts = convex_parts(body, body.simplified.decompose())
    shapes = tuple(shape for part in parts if (shape := hull_shape(part)) is not None)
    headline = f"the collider '{prim.GetName()}' was cut into {len(shapes)} hulls by Mana; other engines cut otherwise"
    note(_converted(headline, where))
    return shapes


def _hull(points: FloatArray, where: Location) -> CollisionShape:
    shape = hull_shape(points)
    if shape is None:
        raise unsupported("a collider that spans no volume", where)
    return shape


def _is_convex(points: FloatArray, triangles: IntArray) -> bool:
    """Whether an outward surface encloses what the hull of its points does, and no more."""
    try:
        full = volume(*convex_hull(points))
    except ValueError:
        return False
    enclosed = volume(points, triangles)
    return CONVEX_SHARE * full <= enclosed <= full / CONVEX_SHARE


def _primitive(prim: Usd.Prim, X_AP: FloatArray) -> CollisionShape | None:
    """The shape itself; None where its kind or its transform has no counterpart."""
    scale = np.linalg.norm(X_AP[:3, :3], axis=0)
    if not np.all(np.isfinite(X_AP)) or not np.all(scale > 0.0):
        return None
    rotation = X_AP[:3, :3] / scale
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > EVEN:
        return None
    if np.linalg.det(rotation) < 0.0:
        rotation = -rotation  # Each of these shapes is its own mirror image about its centre.
    rigid = pose(rotation, X_AP[:3, 3])
    is_even = bool(np.ptp(scale) <= EVEN * scale.max())
    if prim.IsA(UsdGeom.Cube):
        edge = float(UsdGeom.Cube(prim).GetSizeAttr().Get())
        return CollisionShape("box", tuple(float(v) for v in edge * scale), rigid) if edge > 0.0 else None
    if prim.IsA(UsdGeom.Sphere) and is_even:
        radius = float(UsdGeom.Sphere(prim).GetRadiusAttr().Get())
        return CollisionShape("sphere", (radius * float(scale[0]),), rigid) if radius > 0.0 else None
    if (prim.IsA(UsdGeom.Capsule) or prim.IsA(UsdGeom.Cylinder)) and is_even:
        kind, schema = ("capsule", UsdGeom.Capsule) if prim.IsA(UsdGeom.Capsule) else ("cylinder", UsdGeom.Cylinder)
        gprim = schema(prim)
        size = tuple(float(v) * float(scale[0]) for v in (gprim.GetRadiusAttr().Get(), gprim.GetHeightAttr().Get()))
        axis = _AXES[str(gprim.GetAxisAttr().Get())]
        rigid[:3, :3] = rigid[:3, :3] @ shortest_rotation(_AXES["Z"], axis)
        return CollisionShape(kind, size, rigid) if min(size) > 0.0 else None
    return None


def _converted(headline: str, where: Location) -> Diagnostic:
    return finding("asset/foreign-converted", headline, where=where)
