"""Reduces meshes to the triangle budget by decimation, and records the surface distance (metres) that it costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.geometry.distortion import Distortion
from geom.mesh.decimate import decimate_mesh
from geom.mesh.weld import diagonal
from schemas.diagnostics import Diagnostic, finding
from schemas.model import Mesh
from schemas.outcome import Repair


@dataclass(frozen=True)
class BudgetResult:
    """Meshes within the budget, with findings, repairs and distortions where they had to be reduced."""

    meshes: tuple[Mesh, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    distortions: tuple[Distortion, ...] = ()


def within_budget(meshes: Sequence[Mesh], budget: int) -> BudgetResult:
    """Meshes reduced in proportion when together they exceed the triangle budget."""
    total = sum(len(m.triangles) for m in meshes)
    if total <= budget:
        return BudgetResult(tuple(meshes))
    size = diagonal(np.concatenate([m.points for m in meshes]))
    reduced, worst = [], Distortion("decimate", 0.0, 0.0, size)
    for mesh in meshes:
        light, figures = decimate_mesh(mesh, max(64, len(mesh.triangles) * budget // total))
        lost = float(figures["surface_distance_max_m"])
        if lost > worst.length:
            worst = Distortion("decimate", lost, lost, size, mesh.name)
        reduced.append(light)
    after = sum(len(m.triangles) for m in reduced)
    note = finding(
        "asset/too-many-triangles",
        f"{total} triangles were reduced to {after}",
        value=total,
        bound=budget,
        unit="triangles",
    )
    was, now = worst.figures()
    repair = Repair(
        name="decimate",
        code="asset/too-many-triangles",
        stage="canonicalize",
        before={"triangles": total, **was},
        after={"triangles": after, **now},
    )
    return BudgetResult(tuple(reduced), (note,), (repair,), (worst,))
