"""Closed surfaces (metres) that open parts add to the closed bodies: bodies with hidden mouths, walls from sheets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from geom.convex.hull import convex_hull
from geom.mass.inertia import enclosed_volume
from geom.mesh.decimate import decimate
from geom.mesh.surface_distance import NearestOnSurface, triangle_areas
from geom.repair.boundary_loops import OpenBody
from geom.repair.holes import capped_body
from geom.solid.closed_bodies import Bodies, Surface, as_manifold, outward
from geom.solid.thicken import thicken
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import VolumeProperties

# Open parts that extend less than this share of the diagonal beyond the bodies are decoration: labels, decals, trim.
DECORATION_SHARE = 0.01
LEAST_PROBES = 64  # at which an open part is compared with the bodies, beside its corners
WALL_FACES = 1500
# Unconnected faces cannot be decimated; a wall of more plates than this takes minutes.
MOST_PLATES = 4 * WALL_FACES


@dataclass(frozen=True)
class Additions:
    """The closed, outward surfaces that open parts add to the closed bodies.

    capped  parts all of whose mouths other bodies hide, with the hidden faces put back.
    wall    the free sheets as one wall; None without any.
    hulls   the hulls of sheets with too many faces to grow a wall from.
    """

    capped: tuple[Surface, ...] = ()
    wall: Surface | None = None
    hulls: tuple[Surface, ...] = ()


def additions(bodies: Bodies, united: Surface, wall_m: float, size: float, *, hidden: bool = True) -> Additions:
    """The additions of the open parts of `bodies` that extend beyond the `united` ones by more than 1 % of `size` (m).

    A part that encloses a volume once its mouths are capped, with every cap inside the bodies or on them, is a body
    whose hidden faces were left out (a foot under a seat, an eye in a head). All else is a sheet and gets walls of
    `wall_m`, so that its cavity stays open. Without `hidden` every open part is a sheet.
    """
    if not bodies.open_bodies:
        return Additions()
    nearest, slack = NearestOnSurface(*united), DECORATION_SHARE * size
    capped: list[Surface] = []
    sheets: list[OpenBody] = []
    for part in bodies.open_bodies:
        if not _outside(nearest, _spread(bodies.open_surface, part.faces), slack).any():
            continue
        body = _with_hidden_faces(bodies, part, nearest, slack) if hidden else None
        if body is not None:
            capped.append(body)
        else:
            sheets.append(part)
    if not sheets:
        return Additions(tuple(capped))
    points, triangles = bodies.open_surface[0], bodies.open_surface[1][np.concatenate([s.faces for s in sheets])]
    if not triangle_areas(points[triangles]).any():
        return Additions(tuple(capped))
    light = decimate(points, triangles, WALL_FACES)
    if len(light[1]) <= MOST_PLATES and triangle_areas(light[0][light[1]]).any():
        return Additions(tuple(capped), thicken(*light, wall_m))
    return Additions(tuple(capped), None, tuple(h for s in sheets for h in _hull(bodies.open_surface, s, wall_m)))


def wall_bodies(bodies: Bodies, wall_m: float) -> tuple[Surface, ...]:
    """All open parts of `bodies` as one wall of `wall_m`; () when there are none."""
    points, triangles = decimate(bodies.open.points, bodies.open.triangles, WALL_FACES)
    if len(triangles) > MOST_PLATES or not triangle_areas(points[triangles]).any():
        return ()
    return (thicken(points, triangles, wall_m),)


def volume_of_wall(wall: Surface, united: Surface) -> VolumeProperties | None:
    """The volume of a `wall` outside the `united` bodies; None where it is empty."""
    centre = united[0].mean(axis=0)
    rest: Manifold = as_manifold(wall[0] - centre, wall[1]) - as_manifold(united[0] - centre, united[1])
    if rest.is_empty():
        return None
    mesh = rest.to_mesh64()
    points = np.asarray(mesh.vert_properties)[:, :3] + centre
    return enclosed_volume(points, np.asarray(mesh.tri_verts).astype(np.int32))


def _with_hidden_faces(bodies: Bodies, part: OpenBody, nearest: NearestOnSurface, slack: float) -> Surface | None:
    """The `part` capped, when other bodies hide every cap of it; else None."""
    if not part.openings or not part.complete or part.capped_volume == 0.0:
        return None
    points, triangles = capped_body(*bodies.open_surface, part)
    caps = np.arange(len(part.faces), len(triangles))
    if _outside(nearest, _spread((points, triangles), caps), slack).any():
        return None
    body = outward(points, triangles)
    return body if as_manifold(*body).status().name == "NoError" else None


def _spread(surface: Surface, faces: IntArray) -> FloatArray:
    """Points (n, 3) all over some faces: corners, and the centres of equal parts, more of them where faces are few."""
    corners = surface[0][surface[1][faces]]
    parts = int(np.ceil(np.sqrt(LEAST_PROBES / len(faces))))  # of each edge
    i, j = np.nonzero(np.add.outer(np.arange(parts), np.arange(parts)) < parts)
    weights = (np.stack([i, j, parts - 1 - i - j], axis=1) + 1.0 / 3.0) / parts
    return np.concatenate([corners.reshape(-1, 3), np.einsum("wk,fkx->fwx", weights, corners).reshape(-1, 3)])


def _outside(nearest: NearestOnSurface, points: FloatArray, slack: float) -> BoolArray:
    """(n,) True for points outside the closed surface and further than `slack` away from it."""
    away = np.linalg.norm(nearest(points)[0] - points, axis=1) > slack
    return away & ~nearest.inside(points)


def _hull(surface: Surface, part: OpenBody, wall_m: float) -> Sequence[Surface]:
    """The convex hull of a part; of a flat part a slab of thickness `wall_m`."""
    points = surface[0][np.unique(surface[1][part.faces])]
    try:
        return [convex_hull(points)]
    except ValueError:
        centred = points - points.mean(axis=0)
        normal = np.linalg.eigh(centred.T @ centred)[1][:, 0]
        return [convex_hull(np.concatenate([points - 0.5 * wall_m * normal, points + 0.5 * wall_m * normal]))]
