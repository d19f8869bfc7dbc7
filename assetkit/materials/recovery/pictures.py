"""Draws the candidates of all surfaces on the whole object in the standard views, and measures what is seen of each."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image

from assetkit.materials.colour_names import basic_terms, lab_of
from assetkit.materials.recovery.rank import DrawnSurface
from assetkit.storage import require_storage
from geom.mesh.corner_normals import corner_normals
from jobs.cell import Limits
from jobs.warm import run_module
from render.camera import STANDARD_VIEWS
from render.variants.regions import OTHER, regions_of
from render.variants.request import VariantsRequest
from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import Material
from schemas.arrays import FloatArray, IntArray
from schemas.files import array_files
from schemas.model import Mesh, Model

LIMITS: Final = Limits(seconds=60.0, memory_mb=6144)
_MANY_TRIANGLES, _GRID_CELLS = 20_000, 192  # a grid of half a pixel along the longest side
_LEAST_PIXELS = 12  # in four views together; fewer show no shape
_CLIPPED_BELOW, _CLIPPED_ABOVE = 0.02, 0.98  # of the display value, beyond which a pixel is clipped


def draw(
    model: Model, variants: Sequence[Sequence[Material]], regions: Sequence[int], work_dir: Path
) -> list[list[DrawnSurface | None]]:
    """What is seen of the material of each region (index) under each variant: [variant][region]; None where hidden.

    Raises RuntimeError when the renderer fails, OSError when files could not be written or read.
    """
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        request = VariantsRequest(
            _coarse(model), tuple(tuple(materials) for materials in variants), tuple(regions), place
        )
        file = Path(place, "request.npz")
        array_files.save(request, VariantsRequest, file)
        result = run_module("render", ["variants", str(file)], LIMITS)
        require_storage(result)
        if result.status != "ok":
            raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
        region_at = np.concatenate(
            [regions_of(_pixels(Path(place, f"regions_{v.name}.png"))).ravel() for v in STANDARD_VIEWS]
        )
        seen: list[list[DrawnSurface | None]] = []
        for number in range(len(variants)):
            pixels = np.concatenate(
                [_pixels(Path(place, f"{number}_{v.name}.png")).reshape(-1, 3) for v in STANDARD_VIEWS]
            )
            seen.append(_measured(pixels / 255.0, region_at, len(regions)))
    return seen


def _coarse(model: Model) -> Model:
    """A model of many triangles with its points on a grid finer than the pixels, and without what vanishes there."""
    if sum(len(mesh.triangles) for mesh in model.meshes) <= _MANY_TRIANGLES:
        return model
    return replace(model, meshes=tuple(_on_grid(mesh, _step(model)) for mesh in model.meshes))


def _step(model: Model) -> float:
    points = np.concatenate([mesh.points for mesh in model.meshes])
    return float(np.ptp(points, axis=0).max()) / _GRID_CELLS


def _on_grid(mesh: Mesh, step: float) -> Mesh:
    """The mesh with points at multiples of `step`; without triangles of no area and repeated ones."""
    if not step > 0.0 or not len(mesh.triangles):
        return mesh
    normals = corner_normals(mesh.points, mesh.triangles) if mesh.normals is None else mesh.normals
    cells, of_point = np.unique(np.round(mesh.points / step).astype(np.int64), axis=0, return_inverse=True)
    corners = of_point.reshape(-1)[mesh.triangles]
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    flat = (corners[first] == np.roll(corners[first], 1, axis=1)).any(axis=1)
    left = np.sort(first[~flat])
    return replace(
        mesh,
        points=cells * step,
        triangles=corners[left].astype(np.int32),
        normals=normals[left].astype(np.float32),
        uvs=tuple(uvs[left] for uvs in mesh.uvs),
        colors=None if mesh.colors is None else mesh.colors[left],
    )


def _pixels(file: Path) -> IntArray:
    with Image.open(file) as picture:
        return np.asarray(picture.convert("RGB"), dtype=np.int64)


def _measured(display: FloatArray, region_at: IntArray, count: int) -> list[DrawnSurface | None]:
    """What (n, 3) pixels in display values show of each region."""
    linear = np.asarray(srgb_to_linear(display), dtype=np.float64)
    others = region_at == OTHER
    neighbour = lab_of(linear[others].mean(axis=0, keepdims=True))[0] if others.sum() >= _LEAST_PIXELS else None
    results: list[DrawnSurface | None] = []
    for region in range(count):
        inside = region_at == region
        if inside.sum() < _LEAST_PIXELS:
            results.append(None)
            continue
        shown, lab = display[inside], lab_of(linear[inside])
        clipped = np.mean((shown.max(axis=1) <= _CLIPPED_BELOW) | (shown.min(axis=1) >= _CLIPPED_ABOVE))
        mean_lab = lab_of(linear[inside].mean(axis=0, keepdims=True))[0]
        terms, counts = np.unique(basic_terms(linear[inside]), return_counts=True)
        results.append(
            DrawnSurface(
                contrast=round(float(lab[:, 0].std()) / 100.0, 4),
                clipped=round(float(clipped), 3),
                neighbour_lab=None if neighbour is None else round(float(np.linalg.norm(mean_lab - neighbour)), 1),
                colour_shares={
                    str(t): round(float(n) / int(inside.sum()), 3) for t, n in zip(terms, counts, strict=True)
                },
            )
        )
    return results


def with_material_per_surface(
    model: Model, surfaces: Sequence[Sequence[str]], originals: Sequence[int | None]
) -> tuple[Model, list[int]]:
    """The model with a material of its own for each of the surfaces (ids of meshes), and the index of each.

    It is a copy of the original, or a plain one without any.
    """
    materials = list(model.materials)
    index_of: Mapping[str, int] = {}
    indices: list[int] = []
    for ids, original in zip(surfaces, originals, strict=True):
        indices.append(len(materials))
        materials.append(Material("") if original is None else model.materials[original])
        index_of = {**index_of, **dict.fromkeys(ids, indices[-1])}
    meshes = tuple(replace(mesh, material=index_of.get(mesh.id, mesh.material)) for mesh in model.meshes)
    return replace(model, meshes=meshes, materials=tuple(materials)), indices
