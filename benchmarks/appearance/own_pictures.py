"""Mana's own pictures of a source and of its release, and what the shader that Blender reads cannot show."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from assetkit.library.preview_worker import first_model
from assetkit.package.preview_images import render_views
from benchmarks.appearance.cycles import Picture
from benchmarks.assets.heavy_scans import read_model
from render.camera import AnnotationFrame
from schemas.arrays import FloatArray
from schemas.model import Mesh, Model
from usdio.write.materials.mesh_materials import materials_per_mesh
from usdio.write.materials.outputs import lost_by_shader
from usdio.write.materials.preview_surface import PREVIEW_SURFACE


def draw_source(
    file: Path, X_AS: FloatArray, frame: AnnotationFrame, masks: Mapping[str, Picture], work: Path, size_px: int
) -> dict[str, Picture]:
    """The standard views of a source as its reader gives it, in the asset frame; `masks` are those of Cycles."""
    model = read_model(file)
    return _drawn(
        replace(model, meshes=tuple(_moved(mesh, X_AS) for mesh in model.meshes)), frame, masks, work, size_px
    )


def draw_release(
    file: Path, frame: AnnotationFrame, masks: Mapping[str, Picture], work: Path, size_px: int
) -> dict[str, Picture]:
    """The standard views of released USD."""
    return _drawn(first_model(file), frame, masks, work, size_px)


def lacking(file: Path) -> tuple[str, ...]:
    """Fields of the materials of released USD that its UsdPreviewSurface does not show."""
    model = first_model(file)
    images = {texture.name: texture for texture in model.textures}
    lost = (lost_by_shader(each, images)[PREVIEW_SURFACE.name] for each in materials_per_mesh(model))
    return tuple(sorted(set[str]().union(*lost)))


def _drawn(
    model: Model, frame: AnnotationFrame, masks: Mapping[str, Picture], work: Path, size_px: int
) -> dict[str, Picture]:
    half_m = frame.unit_m * frame.extent / 2.0
    views = render_views(model, (frame.centre_m - half_m, frame.centre_m + half_m), work, size_px)
    return {
        name: Picture(
            np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=np.float32) / 255.0, masks[name].alpha
        )
        for name, data in views.items()
    }


def _moved(mesh: Mesh, X_AS: FloatArray) -> Mesh:
    """The mesh in the asset frame; X_AS is a rotation times a scale, and a shift."""
    R = X_AS[:3, :3] / np.cbrt(np.linalg.det(X_AS[:3, :3]))
    normals = None if mesh.normals is None else (mesh.normals @ R.T).astype(np.float32)
    return replace(mesh, points=mesh.points @ X_AS[:3, :3].T + X_AS[:3, 3], normals=normals)
