"""Orientation of open sheets: faces to flip so that the side that sees more of the sky is the front.

The share of the sky that each side sees is estimated by rays from samples of the sheet (m, 3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.mesh.components import components_of
from geom.mesh.duplicate_shells import has_reverse
from geom.mesh.edges import consistent_flips, edges_of, face_components
from geom.mesh.surface_distance import sample_surface, triangle_areas
from geom.mesh.topology import repeats_point
from geom.mesh.weld import weld_points
from geom.repair.boundary_loops import MIN_AREA_SHARE
from schemas.arrays import BoolArray, FloatArray, IntArray

# A sheet is inside out when its front sees less of the sky than this share of what its back sees. A half ball has 1/2,
# a gutter of half a pipe 0.64, two walls at a right angle 0.71, a card 1: from there on either side may be meant.
CLEAR_RATIO = 2.0 / 3.0
# A sheet that sees hardly any sky, hidden in other parts, has no decidable side.
MIN_VISIBLE_SHARE = 0.02
SKY_SAMPLES, SKY_DIRECTIONS = 256, 32
_LIFT = 1e-5  # of the size: where rays start above the face
_GOLDEN_FRACTION = 0.5 * (5.0**0.5 - 1.0)


class SideVisibility(NamedTuple):
    """How much of the sky each side of a sheet sees (0 to 1), averaged over its area with cosine weights."""

    front: float
    back: float

    @property
    def is_inside_out(self) -> bool:
        """Whether the back is clearly the outside."""
        return self.back >= MIN_VISIBLE_SHARE and self.front < CLEAR_RATIO * self.back

    @property
    def is_outside_in(self) -> bool:
        """Whether the front is clearly the outside, as it should be."""
        return SideVisibility(self.back, self.front).is_inside_out


class FlippedSheet(NamedTuple):
    """A sheet with faces to flip: its `faces` (k,), and the share of its inner side in the sky that both sides see."""

    faces: IntArray
    inner_share: float


class SheetFlips(NamedTuple):
    """A mask (m,) of the faces to flip, and the sheets that contain them."""

    flips: BoolArray
    sheets: tuple[FlippedSheet, ...]


def sheet_flips(points: FloatArray, triangles: IntArray, owner: IntArray) -> SheetFlips:
    """The faces of open sheets that are wound inside out, among `triangles` (m, 3) of the meshes `owner` (m,).

    A sheet is connected by edges of two faces, also across meshes. First neighbours are made to agree, by flipping the
    minority; then the whole sheet is flipped when its back clearly sees more of the sky, both alone and with all other
    surfaces as occluders. For a vessel the shares have a closed form: its outside sees all of the sky, its inside as
    much as the area of the mouth over its own (reciprocity of view factors; Howell and Menguc, *Thermal Radiation Heat
    Transfer*).

    Left as they are: sheets with two like sides (`CLEAR_RATIO`); those whose outside other parts hide, as the lining of
    a double wall or a card on a board; one-sided ones (a Moebius strip), those drawn from both sides, and sheets below
    0.1 % of the area.
    """
    flips, flipped_sheets = np.zeros(len(triangles), dtype=bool), list[FlippedSheet]()
    welded = weld_points(points, triangles)[1]
    areas, doubled = triangle_areas(points[triangles]), has_reverse(welded)
    all_surfaces: SkyVisibility | None = None
    for faces in _sheets(points, triangles, welded, owner):
        if doubled[faces].any() or not areas[faces].sum() > MIN_AREA_SHARE * areas.sum():
            continue
        minority, one_sided = consistent_flips(edges_of(welded[faces]))
        if one_sided.any():
            continue
        all_surfaces = all_surfaces or SkyVisibility(points, triangles)
        agreeing = np.where(minority[:, None], triangles[faces][:, [0, 2, 1]], triangles[faces])
        seen = (all_surfaces.of_sheet(agreeing), SkyVisibility(points, agreeing).of_sheet(agreeing))
        inside_out = all(sides.is_inside_out for sides in seen)
        turned = ~minority if inside_out else minority
        if turned.any() and (inside_out or all(sides.is_outside_in for sides in seen)):
            flips[faces] = turned
            flipped_sheets.append(FlippedSheet(faces, max(min(sides) / sum(sides) for sides in seen)))
    return SheetFlips(flips, tuple(flipped_sheets))


class SkyVisibility:
    """The share of the sky that sheets see past occluding surfaces; the search tree is built once."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        """Points (n, 3) and triangles (m, 3) of the occluding surfaces."""
        import open3d as o3d  # Costs a second and 200 MB: loaded only when there are sheets.

        solid = triangles[triangle_areas(points[triangles]) > 0.0]
        used = points[solid].reshape(-1, 3)
        low, high = used.min(axis=0), used.max(axis=0)
        self._points = (points - 0.5 * (low + high)) / (float((high - low).max()) or 1.0)
        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._tensor(self._points.astype(np.float32)), self._tensor(np.ascontiguousarray(solid.astype(np.uint32)))
        )

    def of_sheet(self, triangles: IntArray) -> SideVisibility:
        """Visible sky of both sides of the sheet of `triangles` (k, 3), which must have area, by rays from samples."""
        starts, face = sample_surface(self._points, triangles, SKY_SAMPLES, 0)
        corners = self._points[triangles[face]]
        along = corners[:, 1] - corners[:, 0]
        normals = np.cross(along, corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        frames = np.stack([along, np.cross(normals, along), normals], axis=2)
        local = _cosine_directions(len(starts))
        front = np.einsum("kij,kdj->kdi", frames, local)
        back = np.einsum("kij,kdj->kdi", frames, local * [1.0, 1.0, -1.0])
        return SideVisibility(self._free(starts + _LIFT * normals, front), self._free(starts - _LIFT * normals, back))

    def _free(self, starts: FloatArray, directions: FloatArray) -> float:
        """The share of rays (k, d, 3) from `starts` (k, 3) that hit nothing."""
        rays = np.concatenate([np.broadcast_to(starts[:, None], directions.shape), directions], axis=2)
        hit = self._scene.test_occlusions(self._tensor(rays.reshape(-1, 6).astype(np.float32))).numpy()
        return float(1.0 - hit.mean())


def _cosine_directions(count: int) -> FloatArray:
    """(count, d, 3) upward unit vectors, each row of d cosine-distributed and rotated differently.

    Even points of a disc, lifted onto the half ball (Malley's method).
    """
    k = np.arange(SKY_DIRECTIONS)
    radius = np.sqrt((k + 0.5) / SKY_DIRECTIONS)
    turn = 2.0 * np.pi * (k * _GOLDEN_FRACTION + np.arange(count)[:, None] * _GOLDEN_FRACTION**2)
    height = np.broadcast_to(np.sqrt(1.0 - radius**2), turn.shape)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=2)


def _sheets(points: FloatArray, triangles: IntArray, welded: IntArray, owner: IntArray) -> list[IntArray]:
    """The faces (k,) of each sheet: the open components of each mesh, joined over all meshes by edges of two faces."""
    is_open, proper = np.zeros(len(triangles), dtype=bool), ~repeats_point(welded)
    for mesh in np.unique(owner):
        mesh_faces = np.flatnonzero((owner == mesh) & proper)
        parts = components_of(points, welded[mesh_faces])
        is_open[mesh_faces] = ~parts.closed[parts.label]
    faces = np.flatnonzero(is_open)
    if len(faces) == 0:
        return []
    edges = edges_of(welded[faces])
    count, label = face_components(edges, edges.uses == 2)
    open_edges = np.bincount(label, (edges.uses[edges.of_face] != 2).sum(axis=1), count)
    groups = np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label, minlength=count))[:-1])
    return [faces[group] for group, rim in zip(groups, open_edges, strict=True) if rim]
