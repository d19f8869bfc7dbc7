"""Closed bodies of visual meshes, their open parts, and the union of bodies (manifold3d), in the unit of the points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from geom.mesh.components import MIN_COMPACTNESS, Components, components_of, opposite_container
from geom.mesh.edges import consistent_flips, edges_of
from geom.mesh.edit import flip_faces, keep_faces, merge_surfaces
from geom.mesh.manifold_arrays import manifold_of, signed_volume
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import weld
from geom.repair.back_faces import drop_back_faces
from geom.repair.boundary_loops import OpenBody, classify_open_bodies
from geom.repair.faces import drop_fins, drop_surplus_faces
from geom.repair.holes import capped_body
from geom.repair.shells import drop_duplicate_shells, drop_fragments
from geom.repair.winding import orient
from geom.solid.enclosed_cells import enclosed_cells
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.model import Mesh

Surface = tuple[FloatArray, IntArray]
# In an asset of several parts, a part with at most half the area whose caps are at most this share of its closed area
# is a body whose hidden faces were left out (a board's end, the underside of a cushion).
HIDDEN_FACE_SHARE = 0.13
LEADING_PART_SHARE = 0.5
# Of a surface with open edges the cells count when their faces have this share of its area; else it is a sheet that
# happens to enclose something, such as a blister in a scan, and stays whole.
LEAST_ENCLOSED_SHARE = 0.5
# Of the volume that the winding encloses: cells with less of it have leaked.
LEAST_OF_WOUND = 0.99


@dataclass(frozen=True)
class Bodies:
    """The closed bodies and open parts of visual meshes.

    tidied       each mesh, cleaned (`tidy`).
    by_mesh      closed bodies of each mesh that leaves nothing open, else ().
    closed       closed outward bodies over all meshes, each with its inward cavity shells.
    open         the components that stay open, welded together; their classes are `open_bodies`, whose faces index
                 into `open_surface`, which still contains the capped bodies.
    cavities     cavity shells in `closed`.
    filled       loops capped to close a body.
    closed_area, open_area  visible area of either, caps not counted.
    """

    tidied: tuple[Mesh, ...]
    by_mesh: tuple[tuple[Surface, ...], ...]
    closed: tuple[Surface, ...]
    open: Mesh
    open_surface: Surface
    open_bodies: tuple[OpenBody, ...]
    cavities: int
    filled: int
    closed_area: float
    open_area: float


def sort_bodies(meshes: Sequence[Mesh]) -> Bodies:
    """Weld, drop surplus faces and back faces, orient; first each mesh alone, then what is open over all meshes.

    Parts of different meshes are welded only where they are open, so that bodies in contact stay apart.
    """
    closed: list[Surface] = []
    cavities, closed_area = 0, 0.0
    leftovers: list[Mesh] = []
    by_mesh: list[tuple[Surface, ...]] = []
    tidied = tuple(tidy(mesh) for mesh in meshes)
    for mesh in tidied:
        solids, rest, inner, area = _closed_parts(mesh)
        closed, cavities, closed_area = closed + solids, cavities + inner, closed_area + area
        leftovers.append(rest)
        by_mesh.append(() if len(rest.triangles) else tuple(solids))
    points, triangles, _ = merge_surfaces(leftovers)
    solids, rest, inner, area = _closed_parts(tidy(Mesh("open", points, triangles)))
    rest = _wound_alike(rest)
    closed, cavities, closed_area = closed + solids, cavities + inner, closed_area + area
    edges = edges_of(rest.triangles)
    parts = components_of(rest.points, rest.triangles, edges)
    open_bodies = (*classify_open_bodies(rest.points, rest.triangles, edges, parts), *_edgeless_sheets(parts))
    total = closed_area + float(parts.area.sum())
    is_open = np.ones(len(rest.triangles), dtype=bool)
    capped = tuple(v for v in open_bodies if _is_body(v, total))
    for body in capped:
        closed.append(outward(*capped_body(rest.points, rest.triangles, body)))
        closed_area += body.area
        is_open[body.faces] = False
    return Bodies(
        tidied=tidied,
        by_mesh=tuple(by_mesh),
        closed=tuple(closed),
        open=keep_faces(rest, is_open),
        open_surface=(rest.points, rest.triangles),
        open_bodies=tuple(v for v in open_bodies if not _is_body(v, total)),
        cavities=cavities,
        filled=sum(len(v.openings) for v in capped),
        closed_area=closed_area,
        open_area=max(0.0, total - closed_area),
    )


def tidy(mesh: Mesh) -> Mesh:
    """The bare surface of `mesh`: welded, outward, without surplus, back and fin faces, copies and fragments."""
    bare = weld(Mesh(mesh.name, mesh.points, mesh.triangles))
    if len(bare.triangles) == 0:
        return bare
    bare = drop_surplus_faces(bare)[0]
    bare = drop_back_faces(bare)
    bare = drop_duplicate_shells(bare)[0]
    bare = drop_fins(bare)[0]
    bare = drop_fragments(bare)[0]
    return orient(bare)[0]


def unite(bodies: Sequence[Surface]) -> Surface | None:
    """The union of closed bodies as one closed outward surface, or None when a body is not an oriented manifold.

    Source: manifold3d, guaranteed-manifold booleans. Computed about the common centre; a single body is returned
    unchanged.
    """
    centre = np.mean([points.mean(axis=0) for points, _ in bodies], axis=0)
    solids = [as_manifold(points - centre, triangles) for points, triangles in bodies]
    if any(solid.status() != manifold3d.Error.NoError for solid in solids):
        return None
    if len(bodies) == 1:
        return _compact(*bodies[0])
    union = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if union.status() != manifold3d.Error.NoError or union.is_empty():
        return None
    mesh = union.to_mesh64()
    points, triangles = np.array(mesh.vert_properties)[:, :3] + centre, np.array(mesh.tri_verts).astype(np.int32)
    return points, triangles


def as_manifold(points: FloatArray, triangles: IntArray) -> manifold3d.Manifold:
    """A manifold3d body without unused points; its `status()` is an error when the surface is no oriented manifold."""
    return manifold_of(*_compact(points, triangles))


def _closed_parts(mesh: Mesh) -> tuple[list[Surface], Mesh, int, float]:
    """Closed bodies with their cavities, the remaining faces, the number of cavities and the closed area.

    A component with two faces at every edge is one body. One with more somewhere is as many as it encloses, or one,
    where its winding encloses more: surfaces that cross each other leave no closed cells.
    """
    if len(mesh.triangles) == 0:
        return [], mesh, 0, 0.0
    edges = edges_of(mesh.triangles)
    parts = components_of(mesh.points, mesh.triangles, edges)
    parent = opposite_container(mesh.points, mesh.triangles, parts)
    compact = np.abs(parts.volume) > MIN_COMPACTNESS * parts.area**1.5
    cavity = parts.solid & compact & (parts.volume < 0.0) & (parent >= 0)
    crowded = np.bincount(parts.label[(edges.uses[edges.of_face] > 2).any(axis=1)], minlength=parts.count) > 0
    crowded[parent[cavity]] = False
    wound = parts.solid & compact & (parts.volume > 0.0)
    body = wound & ~crowded
    owner = np.where(cavity, parent, np.arange(parts.count))
    face_owner = np.where((body | (cavity & ~crowded))[parts.label], owner[parts.label], -1)
    bodies = [_compact(mesh.points, mesh.triangles[face_owner == k]) for k in np.flatnonzero(body)]
    left = face_owner < 0
    for part in np.flatnonzero(crowded):
        faces = np.flatnonzero(parts.label == part)
        enclosed, sheets = _enclosed_bodies(mesh.points, mesh.triangles[faces], open_edges=bool(parts.boundary[part]))
        volume = sum(signed_volume(*surface) for surface in enclosed)
        if wound[part] and volume < LEAST_OF_WOUND * parts.volume[part]:
            enclosed, sheets = [_compact(mesh.points, mesh.triangles[faces])], np.zeros(len(faces), dtype=bool)
        bodies += enclosed
        left[faces] = sheets
    area = float(triangle_areas(mesh.points[mesh.triangles[~left]]).sum())
    return bodies, keep_faces(mesh, left), int((cavity & ~crowded).sum()), area


def _enclosed_bodies(points: FloatArray, triangles: IntArray, *, open_edges: bool) -> tuple[list[Surface], BoolArray]:
    """The bodies that a component with crowded edges encloses, and the mask (m,) of faces that are none of theirs."""
    cells = enclosed_cells(points, triangles)
    bodies = [_compact(points, body) for body in cells.bodies]
    areas = triangle_areas(points[triangles])
    enough = not open_edges or areas[~cells.sheets].sum() >= LEAST_ENCLOSED_SHARE * areas.sum()
    if not enough or any(as_manifold(*body).status() != manifold3d.Error.NoError for body in bodies):
        return [], np.ones(len(triangles), dtype=bool)
    return bodies, cells.sheets


def _wound_alike(mesh: Mesh) -> Mesh:
    """`mesh` with neighbours wound alike in each component where they are not, so that its loops can be followed."""
    edges = edges_of(mesh.triangles)
    parts = components_of(mesh.points, mesh.triangles, edges)
    return flip_faces(mesh, consistent_flips(edges)[0] & ~parts.consistent[parts.label])


def _edgeless_sheets(parts: Components) -> tuple[OpenBody, ...]:
    """The components without boundary edges that are no bodies: faces that lie on each other, folded without room."""
    return tuple(
        OpenBody("sheet", np.flatnonzero(parts.label == k), (), False, float(parts.area[k]), 0.0)
        for k in np.flatnonzero(parts.boundary == 0)
    )


def _is_body(body: OpenBody, total_area: float) -> bool:
    if body.kind == "holes":
        return True
    closed_area = body.area + sum(o.area for o in body.openings)
    looped = bool(body.openings) and body.complete and body.capped_volume != 0.0
    minor = body.area <= LEADING_PART_SHARE * total_area
    return looped and minor and closed_area - body.area <= HIDDEN_FACE_SHARE * closed_area


def outward(points: FloatArray, triangles: IntArray) -> Surface:
    """A closed surface without unused points, turned outward when it holds a negative volume."""
    points, triangles = _compact(points, triangles)
    return points, triangles if signed_volume(points, triangles) >= 0.0 else triangles[:, [0, 2, 1]]


def _compact(points: FloatArray, triangles: IntArray) -> Surface:
    used, index = np.unique(triangles, return_inverse=True)
    return points[used], index.reshape(-1, 3).astype(np.int32)
