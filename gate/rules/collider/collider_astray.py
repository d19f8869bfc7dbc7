"""Rule: every collider lies near the visible surface, by the mean distance of its points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import KDTree

from gate.rules.rule import Rule
from gate.subject import Body, Collider, Subject
from gate.subject.body import diagonal
from gate.subject.values import at
from schemas.arrays import BoolArray, FloatArray
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-collider-astray",
    "A single collider stands away from the visible surface",
    "Things bump into empty space.",
    "check place and scale of the collider named",
)
# Shares of the diagonal. The mean over the points of a collider, because one corner of a fitted sliver may reach far.
NEAR, MOST_MEAN = 0.02, 0.025
_CLOUD_SAMPLES = 6000


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package: a finding per collider whose points are, on average, far from the visible surface of its body.

    Points within 2 % of the diagonal, or inside another collider, count as 0.
    """
    for body in subject.active_bodies if subject.released else ():
        surface = _samples(body)
        if len(surface) == 0 or not np.all(np.isfinite(surface)):
            continue
        tree, size_m = KDTree(surface), diagonal(body.visible_points_W)
        for collider in body.active_colliders:
            if len(collider.points_W) == 0 or not np.all(np.isfinite(collider.points_W)):
                continue  # Reported by the collider-shape and mesh-values rules.
            away = tree.query(collider.points_W)[0]
            far = away > NEAR * size_m
            far[far] = ~_covered(collider.points_W[far], collider, body)
            mean_m = float(np.where(far, away, 0.0).mean())
            if mean_m > MOST_MEAN * size_m:
                headline, bound_m = "the collider stands away from the visible surface", MOST_MEAN * size_m
                yield finding(CODE, headline, where=at(collider.prim), value=mean_m, bound=bound_m, unit="m")


def _covered(points: FloatArray, collider: Collider, body: Body) -> BoolArray:
    """(n,) True for points inside another collider, where there is contact anyway."""
    covered = np.zeros(len(points), dtype=bool)
    for other in body.active_colliders:
        if other is not collider and other.hull_W is not None:
            normals, offsets = other.hull_W.planes
            covered |= (points @ normals.T - offsets).max(axis=1) <= 0.0
    return covered


def _samples(body: Body) -> FloatArray:
    """(n, 3) points spread over the visible faces by area (Roberts 2018, R2 sequence), and their corners."""
    faces = [s.points_W[s.triangles] for s in body.surfaces if len(s.triangles)]
    if not faces:
        return np.zeros((0, 3))
    corners = np.concatenate(faces)
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    order = np.arange(_CLOUD_SAMPLES) + 0.5
    chosen = np.minimum(np.searchsorted(area, order / _CLOUD_SAMPLES * area[-1]), len(area) - 1)
    u, v = np.mod(order * 0.7548776662466927, 1.0), np.mod(order * 0.5698402909980532, 1.0)
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    inside = a[chosen] + u[:, None] * (b - a)[chosen] + v[:, None] * (c - a)[chosen]
    return np.concatenate([inside, corners.reshape(-1, 3)[:: max(1, corners.size // (3 * _CLOUD_SAMPLES))]])


RULE = Rule(
    CODE,
    "mean distance of its points <= 2.5 % of the diagonal",
    "one-sided surface distance; packages of real assets",
    check,
)
