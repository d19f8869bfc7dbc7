"""Errors of baked maps: values of the source surface against those of the light one at the nearest place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assetkit.retopo.bake import varying_fields
from assetkit.retopo.projection import Projected, Projector
from assetkit.retopo.surface_values import COLOUR_FIELDS, NORMAL_FIELD, Surface, surfaces_of
from geom.mesh.corner_normals import face_normals
from geom.mesh.surface_distance import sample_surface, triangle_areas
from schemas.appearance.conversions import linear_to_srgb
from schemas.appearance.retopology import MapError, MapUnit
from schemas.arrays import FloatArray
from schemas.evidence import measured
from schemas.model import Mesh, Model

MOST_SAMPLES = 40_000
_METHOD = f"at {MOST_SAMPLES} points of the source surface, against the nearest place of the light mesh"
Errors = dict[str, FloatArray]


def map_errors(source: Model, sources: Sequence[Mesh], result: Model, light: Sequence[Mesh]) -> dict[str, MapError]:
    """The error of each map by name without `_texture`: steps of 255 of display values, degrees between normals.

    `sources` are the meshes of `source` and `light` those of `result` in their place.
    """
    before, after = surfaces_of(source, sources), surfaces_of(result, light)
    areas = np.array([triangle_areas(mesh.points[mesh.triangles]).sum() for mesh in sources])
    counts = np.ceil(MOST_SAMPLES * areas / areas.sum()).astype(int)
    fields = varying_fields(before)
    errors: dict[str, list[FloatArray]] = {}
    for k, count in enumerate(counts):
        for field, values in _errors(before[k], after[k], int(count), fields[k]).items():
            errors.setdefault(field, []).append(values)
    return {field.removesuffix("_texture"): _figures(field, np.concatenate(parts)) for field, parts in errors.items()}


def _figures(field: str, errors: FloatArray) -> MapError:
    unit: MapUnit = "degrees" if field == NORMAL_FIELD else "of 255"
    return MapError(mean=measured(float(errors.mean()), _METHOD), p95=float(np.percentile(errors, 95.0)), unit=unit)


def _errors(source: Surface, light: Surface, count: int, fields: frozenset[str]) -> Errors:
    """Per field the differences (count,) or (count, 3) at points spread over the source."""
    mesh = source.mesh
    points, faces = sample_surface(mesh.points, mesh.triangles, count, 0)
    outward = face_normals(mesh.points, mesh.triangles)[faces].astype(np.float64)
    here = Projector(mesh)(points, outward, 0.0)  # the points themselves, as places on triangles
    projector = Projector(light.mesh)
    there = projector(points, outward, projector.reach_to(points))
    return {field: _difference(field, (source, here), (light, there)) for field in sorted(fields)}


def _difference(field: str, source: tuple[Surface, Projected], light: tuple[Surface, Projected]) -> FloatArray:
    if field == NORMAL_FIELD:
        before, after = (surface.shaded_normals(at.faces, at.weights) for surface, at in (source, light))
        return np.degrees(np.arccos(np.clip(np.einsum("ki,ki->k", before, after), -1.0, 1.0)))
    if field in COLOUR_FIELDS:
        before, after = (linear_to_srgb(s.colour(field, at.faces, at.weights)) for s, at in (source, light))
        return 255.0 * np.abs(before - after).mean(axis=1)
    before, after = (surface.scalar(field, at.faces, at.weights) for surface, at in (source, light))
    return 255.0 * np.abs(before - after)
