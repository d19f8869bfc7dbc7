"""How much a light model looks like its source: silhouettes by rays, and colours of pictures, in the standard views."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from assetkit.package.preview_images import VIEW_PX, render_views
from assetkit.pose.up_axis import TO_Z_UP
from geom.mesh.edit import merge_surfaces
from geom.mesh.rays import Rays
from render.camera import FIELD_OF_VIEW_RAD, STANDARD_VIEWS, CameraView, annotation_frame, camera
from schemas.appearance.retopology import ViewFidelity
from schemas.arrays import BoolArray, FloatArray
from schemas.model import Mesh, Model


def compare_views(source: Model, light: Model, work_dir: Path, size_px: int = VIEW_PX) -> dict[str, ViewFidelity]:
    """What differs between two models in each standard view of the source, by name of the view.

    Both stand z-up in the box of the source. Colours are those of lit pictures, compared where either model is seen.
    """
    before, after = (_upright(model) for model in (source, light))
    points = np.concatenate([mesh.points[np.unique(mesh.triangles)] for mesh in before.meshes])
    box = points.min(axis=0), points.max(axis=0)
    seen = [_silhouettes(model.meshes, box, size_px) for model in (before, after)]
    pictures = [render_views(model, box, work_dir, size_px) for model in (before, after)]
    return {
        view.name: ViewFidelity(
            silhouette_iou=_iou(seen[0][view.name], seen[1][view.name]),
            colour_error_255=_colour_error(
                pictures[0][view.name], pictures[1][view.name], seen[0][view.name] | seen[1][view.name]
            ),
        )
        for view in STANDARD_VIEWS
    }


def _upright(model: Model) -> Model:
    R = TO_Z_UP[model.up_axis.value]
    return replace(
        model,
        meshes=tuple(
            replace(
                mesh,
                points=mesh.points @ R.T,
                normals=None if mesh.normals is None else (mesh.normals @ R.T).astype(np.float32),
            )
            for mesh in model.meshes
        ),
    )


def _silhouettes(meshes: Sequence[Mesh], box: tuple[FloatArray, FloatArray], size_px: int) -> dict[str, BoolArray]:
    frame = annotation_frame(*box)
    points, triangles = merge_surfaces(meshes)[:2]
    rays = Rays(frame.from_asset(points), triangles)
    return {view.name: silhouette(rays, view, frame.extent, size_px) for view in STANDARD_VIEWS}


def silhouette(rays: Rays, view: CameraView, extent: FloatArray, size_px: int) -> BoolArray:
    """(size_px, size_px) where the surface of `rays`, in the annotation frame, is seen; first row at the top."""
    lens = camera(view, extent)
    rows, columns = (index.ravel() for index in np.indices((size_px, size_px)))
    half = np.tan(FIELD_OF_VIEW_RAD / 2.0)
    right = (2.0 * (columns + 0.5) / size_px - 1.0) * half
    up = (1.0 - 2.0 * (rows + 0.5) / size_px) * half
    ways = np.stack([right, up, np.full(rows.size, -1.0)], axis=1)
    ways = (ways / np.linalg.norm(ways, axis=1, keepdims=True)) @ lens.R_NC.T
    starts = np.broadcast_to(lens.position, ways.shape)
    return np.isfinite(rays.hit_distances(starts, ways)).reshape(size_px, size_px)


def _iou(first: BoolArray, second: BoolArray) -> float:
    union = int((first | second).sum())
    return float((first & second).sum()) / union if union else 1.0


def _colour_error(first: bytes, second: bytes, where: BoolArray) -> float:
    """The mean difference of channels, in steps of 255, over the pixels `where` either picture shows the object."""
    if not where.any():
        return 0.0
    pixels = [np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=np.float64) for data in (first, second)]
    return float(np.abs(pixels[0] - pixels[1])[where].mean())
