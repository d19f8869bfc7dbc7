"""Reads mesh primitives: triangles with corner attributes in the frame of their mesh (glTF 2.0, section 3.7.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import DracoPy
import numpy as np

from assetkit.readers.common.corners import Notes, compact, repaired, stray_faces
from assetkit.readers.gltf.accessors import Accessors, normalised
from assetkit.readers.gltf.buffers import Buffers
from assetkit.readers.gltf.json import Json
from geom.mesh.finite import require_finite
from schemas.diagnostics import InvalidInput, Location, finding

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
# Quantised normals miss unit length by up to sqrt(3)/254; a bad normal misses it by far more.
_NORMAL_LENGTH_TOLERANCE: Final = 0.02


@dataclass(frozen=True)
class Primitive:
    """One primitive before any node transform; arrays as in `schemas.model.Mesh`, frame of the mesh, metres."""

    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    uvs: tuple[np.ndarray, ...] = ()
    colors: np.ndarray | None = None
    influences: tuple[np.ndarray, np.ndarray] | None = None  # (n, k) joints and weights of the points.

    def reversed(self) -> Primitive:
        """The same surface with the corners of every triangle the other way round."""
        return replace(
            self,
            triangles=self.triangles[:, ::-1],
            normals=None if self.normals is None else self.normals[:, ::-1],
            uvs=tuple(uv[:, ::-1] for uv in self.uvs),
            colors=None if self.colors is None else self.colors[:, ::-1],
        )


@dataclass(frozen=True)
class _Attributes:
    """Per-vertex arrays by glTF name, and vertex indices in drawing order (None: one after the other)."""

    values: dict[str, np.ndarray]
    indices: np.ndarray | None
    mode: int


def draws_triangles(primitive: Json) -> bool:
    """False for points and lines. Raises InvalidInput `asset/schema-error` for an unknown mode."""
    mode = primitive.integer("mode", _TRIANGLES)
    if mode > _FAN:
        raise primitive.schema_error(f"there is no primitive mode {mode}")
    return mode >= _TRIANGLES


def read_primitive(
    primitive: Json, accessors: Accessors, buffers: Buffers, weights: tuple[float, ...], mesh: str, *, skinned: bool
) -> tuple[Primitive | None, Notes]:
    """The triangles of `primitive`, morphed by `weights`; None when it draws none. `mesh` is its name in findings.

    Strips and fans become lists, v points up, unused vertices are left out. A few faces with missing vertices, bad
    normals and non-finite colours are dropped and noted.
    Raises InvalidInput as `Accessors.read` does; `asset/index-out-of-range` when a tenth of the faces is affected;
    `asset/nonfinite-vertices` naming mesh and vertex; `asset/parse-error` for damaged Draco data.
    """
    where = primitive.where.model_copy(update={"mesh": mesh})
    if primitive.object("attributes").get("POSITION") is None:
        return None, Notes()
    attributes = _read_attributes(primitive, accessors, buffers, skinned)
    positions = attributes.values["POSITION"]
    corners, notes = _triangles(attributes, len(positions), where)
    if len(corners) == 0:
        return None, notes
    morphs = _morphs(primitive, accessors, weights, len(positions))
    points, triangles = compact(positions, corners)
    points = points.astype(np.float64)
    used = np.unique(corners)
    for weight, target in morphs:
        if "POSITION" in target:
            points += weight * target["POSITION"][used]
    require_finite(points, where, numbers=used)
    normals, normal_notes = _normals(attributes, morphs, corners, where)
    uvs, uv_notes = _uvs(attributes, corners, where)
    colors, color_notes = _colors(attributes, corners, where)
    influences = _influences(attributes, used)
    return Primitive(points, triangles, normals, uvs, colors, influences), notes + normal_notes + uv_notes + color_notes


def _read_attributes(primitive: Json, accessors: Accessors, buffers: Buffers, skinned: bool) -> _Attributes:
    """All attributes in use: from Draco data where the extension names them, from their accessors otherwise."""
    types = {"POSITION": ("VEC3",), "NORMAL": ("VEC3",), "COLOR_0": ("VEC3", "VEC4")}
    described = {a.key: a for a in primitive.object("attributes").members()}
    uv_sets = _numbered("TEXCOORD", described)
    followed = [n for kind in ("JOINTS", "WEIGHTS") for n in _numbered(kind, described)] if skinned else []
    types |= dict.fromkeys(followed, ("VEC4",))
    packed = primitive.extension("KHR_draco_mesh_compression")
    unpacked, faces = ({}, None) if packed is None else _decode_draco(packed, buffers)
    values: dict[str, np.ndarray] = {}
    for name in ("POSITION", "NORMAL", *uv_sets, "COLOR_0", *followed):
        if name not in described:
            continue
        allowed = types.get(name, ("VEC2",))
        if name in unpacked:
            index = described[name].as_index(accessors.described, "accessors")
            array = normalised(unpacked[name], accessors.described[index])
            if f"VEC{array.shape[1]}" not in allowed:
                raise described[name].schema_error(f"the Draco data has {array.shape[1]} components")
        else:
            array = accessors.read(described[name], *allowed)
        if values and len(array) != len(values["POSITION"]):
            raise described[name].schema_error(f"{len(array)} elements for {len(values['POSITION'])} vertices")
        values[name] = array
    if faces is not None:
        return _Attributes(values, faces.reshape(-1), _TRIANGLES)
    indices = primitive.get("indices")
    flat = None if indices is None else accessors.read_indices(indices)
    return _Attributes(values, flat, primitive.integer("mode", _TRIANGLES))


def _numbered(kind: str, described: dict[str, Json]) -> list[str]:
    """The attributes of a kind, which are numbered without gaps (3.7.2.1)."""
    count = next(i for i in range(len(described) + 1) if f"{kind}_{i}" not in described)
    return [f"{kind}_{i}" for i in range(count)]


def _influences(attributes: _Attributes, used: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """(n, k) joints and weights of the vertices `used`; None when the primitive is not skinned (3.7.3.3)."""
    joints, weights = (
        [values[used] for name, values in attributes.values.items() if name.startswith(kind)]
        for kind in ("JOINTS_", "WEIGHTS_")
    )
    if not joints or len(joints) != len(weights):
        return None
    return np.concatenate(joints, axis=1).astype(np.int64), np.concatenate(weights, axis=1).astype(np.float64)


def _decode_draco(packed: Json, buffers: Buffers) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Attributes by glTF name and (m, 3) faces of a KHR_draco_mesh_compression block."""
    view = buffers.view(packed.require("bufferView").as_index(buffers.views, "bufferViews"))
    try:
        mesh = DracoPy.decode(bytes(view.data))
    except Exception as error:  # DracoPy's own exceptions share no base class.
        headline = f"damaged Draco data: {error}"
        raise InvalidInput(finding("asset/parse-error", headline, where=packed.where)) from error
    if not isinstance(mesh, DracoPy.DracoMesh):
        raise packed.schema_error("the Draco data is a point cloud, not a mesh")
    by_id = {a["unique_id"]: np.asarray(a["data"]) for a in mesh.attributes}
    values: dict[str, np.ndarray] = {}
    for named in packed.object("attributes").members():
        unique_id = named.as_integer()
        if unique_id not in by_id:
            raise named.schema_error(f"the Draco data has no attribute {unique_id}")
        array = by_id[unique_id]
        values[named.key] = array.reshape(len(array), -1)
    return values, np.asarray(mesh.faces)


def _triangles(attributes: _Attributes, vertices: int, where: Location) -> tuple[np.ndarray, Notes]:
    """(m, 3) vertex indices, all below `vertices`, wound as glTF 2.0, 3.7.2.1 defines for each mode."""
    order = np.arange(vertices) if attributes.indices is None else attributes.indices.astype(np.int64)
    notes = Notes()
    if attributes.mode == _TRIANGLES:
        faces = order[: len(order) // 3 * 3].reshape(-1, 3)
        if len(order) % 3:
            headline = f"{len(order)} corners make no whole number of triangles; the last {len(order) % 3} are left out"
            notes = Notes((finding("asset/empty-face", headline, where=where, value=len(order)),))
    elif len(order) < 3:
        faces = np.zeros((0, 3), dtype=np.int64)
    elif attributes.mode == _STRIP:
        odd = np.arange(len(order) - 2) % 2
        start = np.arange(len(order) - 2)
        faces = order[np.stack([start, start + 1 + odd, start + 2 - odd], axis=1)]
        faces = faces[_distinct(faces)]  # Strips are joined by triangles without area.
    else:
        faces = np.stack([order[1:-1], order[2:], np.full(len(order) - 2, order[0])], axis=1)
    if len(faces) == 0:
        return faces, notes
    missing = np.any(faces >= vertices, axis=1)
    stray = stray_faces(missing, where, points=vertices)
    existing = faces[~missing]
    repairs = tuple(r.model_copy(update={"after": {"faces": len(existing), "bad_faces": 0}}) for r in stray.repairs)
    return existing, notes + replace(stray, repairs=repairs)


def _distinct(faces: np.ndarray) -> np.ndarray:
    a, b, c = faces.T
    return (a != b) & (b != c) & (c != a)


def _morphs(
    primitive: Json, accessors: Accessors, weights: tuple[float, ...], vertices: int
) -> list[tuple[float, dict[str, np.ndarray]]]:
    """(weight, displacement arrays) of each morph target in use (3.7.2.2)."""
    result: list[tuple[float, dict[str, np.ndarray]]] = []
    for weight, target in zip(weights, primitive.items("targets"), strict=False):
        if weight == 0.0:
            continue
        arrays = {a.key: accessors.read(a, "VEC3") for a in target.members() if a.key in {"POSITION", "NORMAL"}}
        if any(len(a) != vertices for a in arrays.values()):
            raise target.schema_error(f"the morph target does not have {vertices} vertices")
        result.append((weight, arrays))
    return result


def _normals(
    attributes: _Attributes,
    morphs: list[tuple[float, dict[str, np.ndarray]]],
    corners: np.ndarray,
    where: Location,
) -> tuple[np.ndarray | None, Notes]:
    """(m, 3, 3) float32 unit corner normals, or None when the file has none or any is zero, long or not finite."""
    if "NORMAL" not in attributes.values:
        return None, Notes()
    stored = attributes.values["NORMAL"][corners].astype(np.float32)
    with np.errstate(all="ignore"):
        bad = ~(np.abs(np.linalg.norm(stored, axis=2) - 1.0) <= _NORMAL_LENGTH_TOLERANCE)
    if bad.any():
        headline = f"{bad.sum()} of {bad.size} corner normals of mesh '{where.mesh}' are not unit length"
        diagnostic = finding("asset/bad-normals", headline, where=where, value=int(bad.sum()), bound=0, unit="corners")
        return None, repaired(diagnostic, "bad_normals", corners=bad.size, bad_corners=int(bad.sum()))
    for weight, target in morphs:
        if "NORMAL" in target:
            stored += np.float32(weight) * target["NORMAL"][corners].astype(np.float32)
    return unit_or_none(stored), Notes()


def unit_or_none(normals: np.ndarray) -> np.ndarray | None:
    """(m, 3, 3) `normals` scaled to unit length, float32; None when one of them has no direction."""
    with np.errstate(all="ignore"):
        unit = normals / np.linalg.norm(normals, axis=2, keepdims=True)
    return unit.astype(np.float32) if np.isfinite(unit).all() else None


def _uvs(attributes: _Attributes, corners: np.ndarray, where: Location) -> tuple[tuple[np.ndarray, ...], Notes]:
    """(m, 3, 2) float32 per UV set, v turned up: glTF counts it from the top of the image (3.8.3)."""
    sets: list[np.ndarray] = []
    notes = Notes()
    for name, values in attributes.values.items():
        if not name.startswith("TEXCOORD_"):
            continue
        uv = values[corners].astype(np.float32)
        bad = ~np.isfinite(uv).all(axis=2)
        if bad.any():
            headline = f"{bad.sum()} corners have no finite {name}; (0, 0) is used there"
            diagnostic = finding("asset/invalid-material-value", headline, where=where, value=int(bad.sum()))
            notes += repaired(diagnostic, "nonfinite_uvs", bad_corners=int(bad.sum()))
            uv[bad] = 0.0
        uv[..., 1] = 1.0 - uv[..., 1]
        sets.append(uv)
    return tuple(sets), notes


def _colors(attributes: _Attributes, corners: np.ndarray, where: Location) -> tuple[np.ndarray | None, Notes]:
    """(m, 3, 4) float32 linear RGBA from COLOR_0, alpha 1 where the file gives none (3.7.2.1: colours are linear)."""
    if "COLOR_0" not in attributes.values:
        return None, Notes()
    stored = attributes.values["COLOR_0"]
    values = stored[corners].astype(np.float32)
    if stored.dtype.kind in "iu":  # Integer colours are fractions even when the file does not declare it.
        values /= np.float32(np.iinfo(stored.dtype).max)
    bad = ~np.isfinite(values).all(axis=2)
    if bad.any():
        headline = f"{bad.sum()} of {bad.size} corner colours of mesh '{where.mesh}' are not finite"
        diagnostic = finding(
            "asset/nonfinite-colors", headline, where=where, value=int(bad.sum()), bound=0, unit="corners"
        )
        return None, repaired(diagnostic, "nan_vertex_color", bad_corners=int(bad.sum()))
    if values.shape[2] == 3:
        values = np.concatenate([values, np.ones((*values.shape[:2], 1), np.float32)], axis=2)
    return values, Notes()
