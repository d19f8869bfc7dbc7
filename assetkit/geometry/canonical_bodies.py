"""Mends the surface of each body of an object on its own, and joins the results to those of the whole object.

A rigid object is one body, with the results of its repair as they are. Of a mechanism every link is one: parts that
touch or reach into each other at rest are no defect there, for they move apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.colliders.self_union import self_union
from assetkit.geometry.physical_surface import PhysicalSurface
from assetkit.geometry.repair import RepairResult, observe_all, repair_geometry
from assetkit.geometry.triangle_budget import BudgetResult, within_budget
from geom.mesh.edit import only_used_points
from geom.solid.closed_bodies import unite
from geom.solid.solid_distance import SolidDistance
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh
from schemas.physics import Solid


@dataclass(frozen=True)
class MendedBody:
    """One body after repair and reduction; `meshes` are the indices of its meshes among those of the object."""

    link: str
    meshes: tuple[int, ...]
    mended: RepairResult
    light: BudgetResult


def mend_bodies(meshes: Sequence[Mesh], budget: int) -> tuple[MendedBody, ...]:
    """The bodies of an object with these meshes (metres), in the order in which they first occur.

    Each gets its share of the triangle budget.
    """
    members: dict[str, list[int]] = {}
    for index, mesh in enumerate(meshes):
        members.setdefault(mesh.link, []).append(index)
    total = sum(len(mesh.triangles) for mesh in meshes)
    bodies: list[MendedBody] = []
    for link, indices in members.items():
        mended = repair_geometry([meshes[i] for i in indices], self_union)
        mine = sum(len(meshes[i].triangles) for i in indices)
        share = budget if len(members) == 1 else max(budget * mine // max(total, 1), 64)
        light = within_budget([only_used_points(m) for m in mended.meshes], share)
        bodies.append(MendedBody(link, tuple(indices), mended, light))
    return tuple(bodies)


@dataclass(frozen=True)
class WholeObject:
    """The results of all bodies together, meshes in the order of the object."""

    mended: RepairResult
    light: BudgetResult
    physical: PhysicalSurface


def joined(meshes: Sequence[Mesh], bodies: Sequence[MendedBody], surfaces: Sequence[PhysicalSurface]) -> WholeObject:
    """The object of `meshes` (before repair) from its bodies and their physical surfaces.

    Of one body the results are its own. The solid of several is the union of theirs, for questions about the form at
    rest; the volume is the sum.
    """
    if len(bodies) == 1:
        return WholeObject(bodies[0].mended, bodies[0].light, surfaces[0])
    mended, light = [b.mended for b in bodies], [b.light for b in bodies]
    order = np.argsort([i for b in bodies for i in b.meshes])
    mended_meshes = [m for r in mended for m in r.meshes]
    light_meshes = [m for r in light for m in r.meshes]
    observed = [t for r in mended for t in r.observed[:-1]]
    mended_in_order = tuple(mended_meshes[i] for i in order)
    change = max((r.change for r in mended), key=lambda c: c.hausdorff)
    whole = RepairResult(
        mended_in_order,
        (*(observed[i] for i in order), observe_all(meshes)),
        observe_all(mended_in_order),
        tuple(d for r in mended for d in r.diagnostics),
        tuple(p for r in mended for p in r.repairs),
        tuple(d for r in mended for d in r.distortions),
        change,
        mended[0].bodies,
        tuple(c for r in mended for c in r.unresolved),
    )
    reduced = BudgetResult(
        tuple(light_meshes[i] for i in order),
        tuple(d for r in light for d in r.diagnostics),
        tuple(p for r in light for p in r.repairs),
        tuple(d for r in light for d in r.distortions),
    )
    return WholeObject(whole, reduced, _joined_surface(surfaces))


def _joined_surface(surfaces: Sequence[PhysicalSurface]) -> PhysicalSurface:
    """All solids as one; `method` is that of the least exact one, `wall` that of the largest sheet."""
    solids = [s.solid for s in surfaces]
    inexact = [s for s in surfaces if s.method != "union"]
    sheets = [s for s in surfaces if s.wall is not None]
    sheet = max(sheets, key=lambda s: s.area_m2) if sheets else None
    points, triangles = _united(solids)
    is_shell = all(solid.kind == "shell" for solid in solids)
    solid = Solid(
        points,
        triangles,
        "shell" if is_shell else "closed",
        solids[0].wall_thickness_m if is_shell else None,
    )
    added = max((s.distance.added for s in surfaces), key=lambda d: d.attained)
    missing = max((s.distance.missing for s in surfaces), key=lambda d: d.attained)
    return PhysicalSurface(
        solid,
        method=max(inexact, key=lambda s: s.volume_m3).method if inexact else "union",
        volume_m3=sum(s.volume_m3 for s in surfaces),
        area_m2=sum(s.area_m2 for s in surfaces),
        wall=sheet.wall if sheet is not None else None,
        distance=SolidDistance(added, missing),
        repairs=tuple(p for s in surfaces for p in s.repairs),
        distortions=tuple(d for s in surfaces for d in s.distortions),
        diagnostics=tuple(d for s in surfaces for d in s.diagnostics),
    )


def _united(solids: Sequence[Solid]) -> tuple[FloatArray, IntArray]:
    """The union of the closed solids beside the sheets; where no union can be formed, the surfaces side by side."""
    closed = [(s.points, s.triangles) for s in solids if s.kind != "shell"]
    union = unite(closed) if closed else None
    surfaces = [union] if union is not None else closed
    surfaces += [(s.points, s.triangles) for s in solids if s.kind == "shell"]
    starts = np.cumsum([0, *(len(points) for points, _ in surfaces)])
    triangles = [t.astype(np.int32) + np.int32(start) for (_, t), start in zip(surfaces, starts, strict=False)]
    return np.concatenate([points for points, _ in surfaces]), np.concatenate(triangles)
