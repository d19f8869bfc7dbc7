"""Reads one UsdGeom gprim as triangles with per-corner attributes, in the frame of the prim."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from geom.mesh import primitives
from geom.mesh.finite import require_finite
from geom.mesh.polygon_triangulation import triangulate_polygons
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.outcome import Outcome
from usdio.read.gprim_mesh import GprimMesh, with_reversed_winding

# Where an attribute has samples, the earliest counts; otherwise its default value.
EARLIEST: Final = Usd.TimeCode.EarliestTime()
IMPLICIT_SHAPES: Final = ("Cube", "Sphere", "Cylinder", "Cylinder_1", "Cone", "Capsule", "Capsule_1", "Plane")
FACELESS: Final = ("Points", "BasisCurves", "NurbsCurves", "HermiteCurves")
UNSUPPORTED: Final = ("NurbsPatch", "TetMesh", "Volume")  # These bound or fill a body, but not by triangles.


def read_implicit_shape(prim: Usd.Prim, where: Location) -> Outcome[GprimMesh]:
    """The tessellated implicit shape (UsdGeom: Cube, Sphere, Cylinder, Cone, Capsule, Plane), 48 segments around.

    The outcome's value is None when a size is zero. Raises InvalidInput `asset/nonfinite-vertices` for a size that is
    NaN or infinite, `asset/schema-error` for a negative one.
    """
    sizes = _sizes(prim, where)
    if 0.0 in (sizes.get("size"), sizes.get("radius"), sizes.get("width"), sizes.get("length")):
        return Outcome(None)
    shape = _tessellate(prim.GetTypeName(), sizes, _token(prim, "axis", "Z"))
    order = {"X": [2, 0, 1], "Y": [1, 2, 0]}.get(_token(prim, "axis", "Z"), [0, 1, 2])  # cyclic: handedness stays
    topology = _Topology(shape.triangles.reshape(-1), np.arange(shape.triangles.size).reshape(-1, 3), np.arange(0))
    constant, colors, notes = _display_color(prim, topology, where)
    surface = GprimMesh(
        shape.points[:, order],
        shape.triangles,
        shape.normals[..., order],
        colors=colors,
        constant_color=constant,
        double_sided=_double_sided(prim),
    )
    return Outcome(surface, notes)


def read_mesh(prim: Usd.Prim, where: Location) -> Outcome[GprimMesh]:
    """The triangulated control cage of a Mesh prim; the value is None when the prim has no points or no faces.

    Faces listed in `holeIndices` are left out. Attributes whose length fits no interpolation are dropped with a
    warning. Raises InvalidInput: `asset/schema-error` when counts and indices disagree, `asset/index-out-of-range`,
    `asset/nonfinite-vertices`.
    """
    mesh = UsdGeom.Mesh(prim)
    points = _array(mesh.GetPointsAttr(), (-1, 3), np.float64)
    counts = _array(mesh.GetFaceVertexCountsAttr(), (-1,), np.int64)
    indices = _array(mesh.GetFaceVertexIndicesAttr(), (-1,), np.int64)
    if len(points) == 0 or len(counts) == 0:
        return Outcome(None)
    _check_topology(points, counts, indices, where)
    holes = _array(mesh.GetHoleIndicesAttr(), (-1,), np.int64)
    solid = (counts >= 3) & ~np.isin(np.arange(len(counts)), holes)
    notes: list[Diagnostic] = []
    empty = int((counts < 3).sum())
    if empty:
        notes.append(finding("asset/empty-face", f"{empty} faces have fewer than 3 corners", where=where, value=empty))
    corners = np.flatnonzero(np.repeat(solid, counts))
    if len(corners) == 0:
        return Outcome(None, tuple(notes))
    cut, owner = triangulate_polygons(points, indices[corners], counts[solid])
    topology = _Topology(indices, corners[cut], np.flatnonzero(solid)[owner])
    uvs, uv_notes = _uvs(prim, topology, where)
    constant, colors, color_notes = _display_color(prim, topology, where)
    normals, normal_notes = _normals(prim, topology, where)
    surface = GprimMesh(
        points,
        indices[topology.corners],
        normals,
        uvs,
        colors,
        constant,
        _subsets(prim, topology.faces),
        _double_sided(prim),
    )
    left_handed = _token(prim, "orientation", "rightHanded") == UsdGeom.Tokens.leftHanded
    return Outcome(
        with_reversed_winding(surface) if left_handed else surface, (*notes, *uv_notes, *color_notes, *normal_notes)
    )


@dataclass(frozen=True)
class _Topology:
    """indices (c,) point of each face corner; corners (m, 3) face corners of each triangle; faces (m,) its face."""

    indices: np.ndarray
    corners: np.ndarray
    faces: np.ndarray

    def per_corner(self, values: np.ndarray, interpolation: str) -> np.ndarray | None:
        """(m, 3, k) per-corner values from (v, k) authored ones (UsdGeomPrimvar), or None when the length is wrong."""
        m = len(self.corners)
        if interpolation == UsdGeom.Tokens.constant:
            picks = np.zeros((m, 3), np.int64)
        elif interpolation == UsdGeom.Tokens.uniform:
            picks = np.repeat(self.faces[:, None], 3, axis=1)
        elif interpolation == UsdGeom.Tokens.faceVarying:
            picks = self.corners
        else:
            picks = self.indices[self.corners]
        return values[picks] if picks.size and len(values) > picks.max() else None


def _check_topology(points: np.ndarray, counts: np.ndarray, indices: np.ndarray, where: Location) -> None:
    if counts.min() < 0 or counts.sum() != len(indices):
        raise InvalidInput(
            finding(
                "asset/schema-error",
                "faceVertexCounts and faceVertexIndices disagree",
                where=where,
                value=len(indices),
                bound=int(counts.sum()),
                unit="corners",
            )
        )
    wrong = (indices < 0) | (indices >= len(points))
    if wrong.any():
        # USD fixes the topology of a mesh as a whole: one impossible index makes all of it suspect.
        raise InvalidInput(
            finding(
                "asset/index-out-of-range",
                f"{int(wrong.sum())} of {len(indices)} face corners refer to none of the {len(points)} points",
                where=where,
                value=int(indices[wrong][0]),
                bound=len(points) - 1,
            )
        )
    require_finite(points, where, row="point")


def _array(attribute: Usd.Attribute, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """The attribute's values, empty when it has none. Raises InvalidInput `asset/schema-error` for another type."""
    value = attribute.Get(EARLIEST) if attribute else None
    try:
        with np.errstate(invalid="ignore"):
            return np.asarray(value if value is not None else [], dtype=dtype).reshape(shape)
    except (TypeError, ValueError) as error:
        raise InvalidInput(_wrong_type(attribute)) from error


def _wrong_type(attribute: Usd.Attribute) -> Diagnostic:
    at = Location(prim=str(attribute.GetPath()))
    headline = f"{attribute.GetName()} has values of another type than its schema says"
    return finding("asset/schema-error", headline, where=at, value=str(attribute.GetTypeName()))


def _token(prim: Usd.Prim, name: str, fallback: str) -> str:
    value = prim.GetAttribute(name).Get(EARLIEST) if prim.HasAttribute(name) else None
    return str(value) if value else fallback


def _double_sided(prim: Usd.Prim) -> bool:
    return bool(UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(EARLIEST))


def _primvar_corners(primvar: UsdGeom.Primvar, width: int, topology: _Topology) -> np.ndarray | None:
    """(m, 3, width) float64 values of a primvar, indices followed; None when it does not fit the mesh."""
    values = _array(primvar.GetAttr(), (-1, width), np.float64)
    if len(values) == 0:
        return None
    if primvar.IsIndexed():
        order = _array(primvar.GetIndicesAttr(), (-1,), np.int64)
        if len(order) == 0 or order.min() < 0 or order.max() >= len(values):
            return None
        values = values[order]
    return topology.per_corner(values, primvar.GetInterpolation())


def _misfit(name: str, where: Location) -> Diagnostic:
    return finding(
        "asset/schema-error",
        f"'{name}' does not have as many values as its interpolation needs; it was left out",
        where=where,
        value=name,
        severity=Severity.WARNING,
    )


def _uvs(prim: Usd.Prim, topology: _Topology, where: Location) -> tuple[dict[str, np.ndarray], tuple[Diagnostic, ...]]:
    """UV sets by primvar name: every texture coordinate, and two-component arrays named like one."""
    uv_sets: dict[str, np.ndarray] = {}
    notes: list[Diagnostic] = []
    for primvar in UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance():
        kind, name = primvar.GetTypeName(), primvar.GetPrimvarName()
        if not kind:
            continue
        is_uv = kind.role == "TextureCoordinate" or name.lower().startswith(("st", "uv"))
        if not is_uv or kind.scalarType not in _PAIRS:
            continue
        values = _primvar_corners(primvar, 2, topology)
        if values is None or not np.isfinite(values).all():
            notes.append(_misfit(f"primvars:{name}", where))
        else:
            uv_sets[name] = values
    return {name: uv_sets[name] for name in sorted(uv_sets, key=lambda n: (n != "st", n))}, tuple(notes)


_TYPES = Sdf.ValueTypeNames
_PAIRS: Final = (
    *(_TYPES.TexCoord2f, _TYPES.TexCoord2d, _TYPES.TexCoord2h),
    *(_TYPES.Float2, _TYPES.Double2, _TYPES.Half2),
)


def _display_color(
    prim: Usd.Prim, topology: _Topology, where: Location
) -> tuple[tuple[float, float, float] | None, np.ndarray | None, tuple[Diagnostic, ...]]:
    """displayColor and displayOpacity as one constant colour, or as (m, 3, 4) linear colours, or neither."""
    api = UsdGeom.PrimvarsAPI(prim)
    color = api.FindPrimvarWithInheritance("displayColor")
    if not color or not color.HasValue():
        return None, None, ()
    values = _primvar_corners(color, 3, topology)
    if values is None:
        return None, None, (_misfit("primvars:displayColor", where),)
    if not np.isfinite(values).all():
        return None, None, (finding("asset/nonfinite-colors", "displayColor is not finite", where=where),)
    values = np.clip(values, 0.0, 1.0)
    opacity = api.FindPrimvarWithInheritance("displayOpacity")
    alpha = _primvar_corners(opacity, 1, topology) if opacity and opacity.HasValue() else None
    if alpha is None or not np.isfinite(alpha).all():
        alpha = np.ones((*values.shape[:2], 1))
    if (values == values[0, 0]).all() and (alpha == 1.0).all():
        r, g, b = (float(c) for c in values[0, 0])
        return (r, g, b), None, ()
    return None, np.concatenate([values, np.clip(alpha, 0.0, 1.0)], axis=2), ()


def _normals(prim: Usd.Prim, topology: _Topology, where: Location) -> tuple[np.ndarray | None, tuple[Diagnostic, ...]]:
    """Corner normals; `primvars:normals` wins over `normals` (UsdGeomMesh documentation)."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("normals")
    if primvar and primvar.HasValue():
        values = _primvar_corners(primvar, 3, topology)
        return values, () if values is not None else (_misfit("primvars:normals", where),)
    mesh = UsdGeom.Mesh(prim)
    authored = _array(mesh.GetNormalsAttr(), (-1, 3), np.float64)
    if len(authored) == 0:
        return None, ()
    values = topology.per_corner(authored, mesh.GetNormalsInterpolation())
    return values, () if values is not None else (_misfit("normals", where),)


def _subsets(prim: Usd.Prim, faces: np.ndarray) -> tuple[tuple[Usd.Prim, np.ndarray], ...]:
    """Material GeomSubsets and the triangles each one owns; a face claimed twice stays with the first."""
    free = np.ones(len(faces), dtype=bool)
    owned: list[tuple[Usd.Prim, np.ndarray]] = []
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        rows = np.flatnonzero(free & np.isin(faces, _array(subset.GetIndicesAttr(), (-1,), np.int64)))
        free[rows] = False
        if len(rows):
            owned.append((subset.GetPrim(), rows))
    return tuple(owned)


def _sizes(prim: Usd.Prim, where: Location) -> dict[str, float]:
    """All numeric sizes of an implicit shape by attribute name, schema fallbacks included."""
    sizes: dict[str, float] = {}
    for name in ("size", "radius", "radiusTop", "radiusBottom", "height", "width", "length"):
        value = prim.GetAttribute(name).Get(EARLIEST) if prim.HasAttribute(name) else None
        if value is None:
            continue
        at = where.model_copy(update={"prim": f"{prim.GetPath()}.{name}"})
        if not isinstance(value, float | int):
            raise InvalidInput(_wrong_type(prim.GetAttribute(name)))
        if not np.isfinite(value):
            raise InvalidInput(finding("asset/nonfinite-vertices", f"{name} is not finite", where=at, value=str(value)))
        if value < 0:
            raise InvalidInput(finding("asset/schema-error", f"{name} is negative", where=at, value=value, bound=0.0))
        sizes[name] = float(value)
    return sizes


def _tessellate(kind: str, sizes: dict[str, float], axis: str) -> primitives.Tessellation:
    radius = sizes.get("radius", 0.0)
    bottom, top = sizes.get("radiusBottom", radius), sizes.get("radiusTop", radius)
    if kind == "Cube":
        return primitives.cube(sizes["size"])
    if kind == "Sphere":
        return primitives.sphere(radius)
    if kind == "Cone":
        return primitives.cylinder(sizes["height"], radius, 0.0)
    if kind.startswith("Cylinder"):
        return primitives.cylinder(sizes["height"], bottom, top)
    if kind.startswith("Capsule"):
        return primitives.capsule(sizes["height"], bottom, top)
    # UsdGeomPlane: width is along x, but along z when the axis is x; length along y, but along z when the axis is y.
    width, length = sizes["width"], sizes["length"]
    return primitives.plane(length, width) if axis in ("X", "Y") else primitives.plane(width, length)
