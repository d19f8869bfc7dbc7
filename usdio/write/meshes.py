"""Authors the visible meshes of a package: topology, normals, UV sets, colours, material binding, part subsets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade, Vt

from geom.mesh.corner_normals import corner_normals, face_vectors
from schemas.arrays import AnyFloatArray, Float32Array, FloatArray, IntArray
from schemas.model import Mesh, Model
from schemas.parts import Part
from usdio.write.materials.mesh_materials import MeshMaterial, uv_primvar

PART_FAMILY = "manaPart"
_MAX_ROLLS = 1000


class BodyFrame(NamedTuple):
    """The prim of a body, and where its frame lies (3,) in the asset frame, with the same axes."""

    path: Sdf.Path
    origin_m: FloatArray


def author_meshes(
    stage: Usd.Stage,
    root: Sdf.Path,
    model: Model,
    mesh_materials: Sequence[MeshMaterial],
    parts: Sequence[Part] = (),
    frames: Mapping[str, BodyFrame] | None = None,
) -> set[bytes]:
    """Define `<body>/Visuals/<id>` for every mesh with triangles; `mesh_materials` holds one per mesh.

    `frames` are those of the bodies by their link; without them all is one body at `root`. Points keep their order and
    sharing. Each of `parts` becomes a face subset of the meshes it lies on. A mesh that equals an earlier one in
    position, shape and material is left out: it adds nothing visible and fails VG.008. Returns the corner orders taken,
    see `distinct_corner_order`.
    """
    frames = frames or {"": BodyFrame(root, np.zeros(3))}
    for frame in frames.values():
        UsdGeom.Xform.Define(stage, frame.path.AppendChild("Visuals"))
    taken: set[bytes] = set()
    written: set[bytes] = set()
    for (mesh_id, mesh), mesh_material in zip(model.meshes_by_id.items(), mesh_materials, strict=True):
        if len(mesh.triangles) == 0:
            continue
        content = _mesh_key(mesh, mesh_material)
        if content in written:
            continue
        written.add(content)
        frame = frames[mesh.link]
        path = frame.path.AppendChild("Visuals").AppendChild(mesh_id)
        if frame.origin_m.any():
            mesh = replace(mesh, points=mesh.points - frame.origin_m)
        corners = distinct_corner_order(mesh.points, mesh.triangles, taken)
        prim = _author_mesh(stage, path, _with_corner_order(mesh, corners), mesh_material, root)
        _author_parts(prim, mesh_id, corners[::3] // 3, parts)
    return taken


def define_mesh(stage: Usd.Stage, path: Sdf.Path, points: FloatArray, triangles: IntArray) -> UsdGeom.Mesh:
    """A plain triangle mesh prim: points (float32), topology, extent, no subdivision. Shared with the colliders."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    points32 = np.ascontiguousarray(points, dtype=np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points32))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(triangles, np.int32).reshape(-1)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    extent = np.stack([points32.min(axis=0), points32.max(axis=0)])
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))
    return mesh


def author_normals(mesh: UsdGeom.Mesh, normals: AnyFloatArray, interpolation: str) -> None:
    """`primvars:normals` (never the plain `normals` attribute: VG.027 allows one of the two)."""
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, interpolation)
    primvar.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals, dtype=np.float32).reshape(-1, 3)))


def _author_mesh(
    stage: Usd.Stage, path: Sdf.Path, mesh: Mesh, mesh_material: MeshMaterial, root: Sdf.Path
) -> UsdGeom.Mesh:
    prim = define_mesh(stage, path, mesh.points, mesh.triangles)
    author_normals(prim, _outward_normals(mesh), UsdGeom.Tokens.faceVarying)
    primvars = UsdGeom.PrimvarsAPI(prim)
    for uv_set, uvs in enumerate(mesh.uvs):
        primvar = primvars.CreatePrimvar(
            uv_primvar(uv_set), Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        placed = np.nan_to_num(uvs, nan=0.0, posinf=0.0, neginf=0.0)
        primvar.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(placed, dtype=np.float32).reshape(-1, 2)))
    _author_colors(prim, mesh, mesh_material)
    prim.CreateDoubleSidedAttr(mesh_material.material.double_sided)
    prim.GetPrim().SetCustomDataByKey("mana:sourceName", mesh.name)
    prim.GetPrim().SetCustomDataByKey("mana:sourcePath", mesh.source_path)
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim())
    # By path: the material lives in another layer, so `Bind` has no prim to take here.
    binding = prim.GetPrim().CreateRelationship(UsdShade.Tokens.materialBinding, custom=False)
    binding.SetTargets([root.AppendChild("Materials").AppendChild(mesh_material.prim_name)])
    return prim


def _author_parts(mesh: UsdGeom.Mesh, mesh_id: str, listed: IntArray, parts: Sequence[Part]) -> None:
    """A subset per part with triangles on the mesh; `listed` (m,) is the source triangle of each authored face.

    Parts may lie within each other, so their family is unrestricted. Unknown labels and materials are not written.
    """
    for part in parts:
        places = np.flatnonzero(part.mask(mesh_id, len(listed))[listed])
        if len(places) == 0:
            continue
        indices = Vt.IntArray.FromNumpy(places.astype(np.int32))
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, part.part_id, UsdGeom.Tokens.face, indices, PART_FAMILY)
        if part.label.confidence > 0.0:
            subset.GetPrim().SetCustomDataByKey("mana:partLabel", part.label.value)
            subset.GetPrim().SetCustomDataByKey("mana:partLabelConfidence", part.label.confidence)
        if part.material.confidence > 0.0:
            subset.GetPrim().SetCustomDataByKey("mana:partMaterial", part.material.value)
            subset.GetPrim().SetCustomDataByKey("mana:partMaterialConfidence", part.material.confidence)
    if parts:
        UsdGeom.Subset.SetFamilyType(mesh, PART_FAMILY, UsdGeom.Tokens.unrestricted)


def _author_colors(prim: UsdGeom.Mesh, mesh: Mesh, mesh_material: MeshMaterial) -> None:
    """displayColor: the vertex colours times the base colour, or the base colour alone for viewers without shaders."""
    base = np.clip(np.asarray(mesh_material.material.base_color, dtype=np.float32), 0.0, 1.0)
    if mesh.colors is None:
        color, interpolation = base.reshape(1, 3), UsdGeom.Tokens.constant
    else:
        rgba = np.clip(mesh.colors.reshape(-1, 4).astype(np.float32), 0.0, 1.0)
        color, interpolation = rgba[:, :3] * base, UsdGeom.Tokens.faceVarying
        if mesh_material.material.alpha_mode != "opaque":
            opacity = np.ascontiguousarray(rgba[:, 3] * np.float32(mesh_material.material.opacity))
            prim.CreateDisplayOpacityPrimvar(interpolation).Set(Vt.FloatArray.FromNumpy(opacity))
    prim.CreateDisplayColorPrimvar(interpolation).Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(color)))


def _outward_normals(mesh: Mesh) -> AnyFloatArray:
    """(m, 3, 3) unit normals that agree with the winding, which is the authority on outside (VG.029)."""
    if mesh.normals is None:
        return corner_normals(mesh.points, mesh.triangles)
    computed = None
    length = np.linalg.norm(mesh.normals, axis=2, keepdims=True)
    bad = ~np.isfinite(length) | (length < 1e-6)
    normals = mesh.normals / np.where(bad, 1.0, length)
    if bad.any():
        computed = corner_normals(mesh.points, mesh.triangles)
        normals = np.where(bad, computed, normals)
    agreement = np.einsum("fi,fci->", face_vectors(mesh.points, mesh.triangles), normals)
    return -normals if agreement < 0.0 else normals


def distinct_corner_order(points: FloatArray, triangles: IntArray, taken: set[bytes]) -> IntArray:
    """A corner order (3 m,) under which points and triangles are unlike every mesh in `taken`, which grows by it.

    VG.008 calls two meshes coincident when their lists of points (to 1e-6) and indices agree. A collider may well
    equal the visible box; listing its faces, or the corners within them, in another cyclic order makes them distinct.
    """
    place = np.round(points.astype(np.float32).astype(np.float64), 6).tobytes()
    flat = np.ascontiguousarray(triangles, dtype=np.int32).reshape(-1)
    order = np.arange(len(flat)).reshape(-1, 3)
    for roll in range(min(_MAX_ROLLS, len(flat))):
        rolled = np.roll(np.roll(order, roll // 3, axis=0), roll % 3, axis=1).reshape(-1)
        key = place + flat[rolled].tobytes()
        if key not in taken:
            taken.add(key)
            return rolled
    return order.reshape(-1)


def _with_corner_order(mesh: Mesh, corners: IntArray) -> Mesh:
    """`mesh` with its corners, and all corner attributes, in the order `corners` (3 m,)."""

    def reordered(values: Float32Array) -> Float32Array:
        return values.reshape(-1, values.shape[2])[corners].reshape(values.shape)

    return replace(
        mesh,
        triangles=mesh.triangles.reshape(-1)[corners].reshape(-1, 3),
        normals=None if mesh.normals is None else reordered(mesh.normals),
        uvs=tuple(reordered(uvs) for uvs in mesh.uvs),
        colors=None if mesh.colors is None else reordered(mesh.colors),
    )


def _mesh_key(mesh: Mesh, mesh_material: MeshMaterial) -> bytes:
    arrays = (mesh.points.astype(np.float32), mesh.triangles, mesh.normals, mesh.colors, *mesh.uvs)
    parts = (np.ascontiguousarray(a).tobytes() for a in arrays if a is not None)
    return b"".join((mesh_material.prim_name.encode(), *parts))
