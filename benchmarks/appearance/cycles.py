"""Drawings by Blender's Cycles of a source file or of released USD, in the light and from the views of Mana's pictures.

Blender reads the file by its own importer, in a process of its own (`cycles_worker`). Everything is drawn in the
annotation frame N of the released asset (`render.camera`), so lamps and clipping do not depend on the size.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from assetkit.blender import environment
from render.camera import FIELD_OF_VIEW_RAD, STANDARD_VIEWS, AnnotationFrame, CameraView, camera
from render.studio import BACKGROUND_SRGB, LAMPS
from render.studio import environment as radiance
from schemas.arrays import Float32Array, FloatArray

WORKER = Path(__file__).with_name("cycles_worker.py")
SEED = 1  # of the paths; any number
LIMIT_S = 900.0  # for one file; the slowest of the samples takes 90 s on one busy core
# Blender turns what it reads of glTF (y up) z up: its (x, y, z) is the file's (x, z, -y).
R_SB = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


class NotDrawn(Exception):
    """Blender is absent, or drew fewer pictures than there are views; the text holds its last lines."""


@dataclass(frozen=True)
class Quality:
    """Pixels a side, paths per pixel, and threads of one drawing by Cycles; the pictures do not depend on threads."""

    size_px: int = 160
    samples: int = 16
    threads: int = 2


@dataclass(frozen=True)
class Picture:
    """rgb (h, w, 3) is sRGB 0..1 over the studio's background, alpha (h, w) the object's share of each pixel."""

    rgb: Float32Array
    alpha: Float32Array


def draw(
    file: Path,
    X_AB: FloatArray,
    frame: AnnotationFrame,
    out: Path,
    quality: Quality,
    seed: int = SEED,
    views: Sequence[CameraView] = STANDARD_VIEWS,
) -> dict[str, Picture]:
    """Views of a file by name; X_AB (4, 4) is the asset frame from that in which Blender imports.

    A drawing of the same request that lies in `out` is read instead. Raises NotDrawn.
    """
    program = environment.python()
    if program is None:
        raise NotDrawn("Blender is not installed: `mana setup blender` brings it")
    out.mkdir(parents=True, exist_ok=True)
    light = out / "environment.npy"
    np.save(light, radiance()[..., 0])
    request = {
        "file": str(file.resolve()),
        "sha256": _digest(file),
        "X_NB": (_to_annotation_frame(frame) @ X_AB).tolist(),
        "cameras": _cameras(views, frame.extent),
        "fov_rad": FIELD_OF_VIEW_RAD,
        "size_px": quality.size_px,
        "samples": quality.samples,
        "threads": quality.threads,
        "seed": seed,
        "environment": str(light.resolve()),
        "lamps": [{"towards_C": lamp.towards_C, "irradiance": lamp.intensity} for lamp in LAMPS],
        "out": str(out.resolve()),
    }
    _run(program, request, out)
    return {view.name: read_picture(out / f"{view.name}.png") for view in views}


def from_gltf(X_AS: FloatArray) -> FloatArray:
    """X_AB (4, 4), from the frame in which Blender imports a glTF file, for X_AS from the axes of that file."""
    X_AB = X_AS.copy()
    X_AB[:3, :3] = X_AS[:3, :3] @ R_SB
    return X_AB


def read_picture(file: Path) -> Picture:
    """A PNG with alpha over the background of the studio."""
    pixels = np.asarray(Image.open(file).convert("RGBA"), dtype=np.float32) / 255.0
    alpha = pixels[..., 3]  # PNG holds colours that are not multiplied by it.
    behind = np.float32(BACKGROUND_SRGB / 255.0)
    return Picture((behind + (pixels[..., :3] - behind) * alpha[..., None]).astype(np.float32), alpha)


def _run(program: Path, request: dict[str, Any], out: Path) -> None:
    text = json.dumps(request, indent=1)
    done = out / "request.json"
    if done.exists() and done.read_text() == text:
        return
    done.unlink(missing_ok=True)
    pending = out / "pending.json"
    pending.write_text(text)
    child = subprocess.run(
        [str(program), "-I", str(WORKER), str(pending)], capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    absent = [name for name in request["cameras"] if not (out / f"{name}.png").exists()]
    if child.returncode or absent:
        raise NotDrawn(f"no pictures {absent} of {request['file']}: {(child.stdout + child.stderr)[-600:]}")
    pending.rename(done)


def _digest(file: Path) -> str:
    """A hash of the file, and of its whole folder where it reads other files."""
    files = [file] if file.suffix == ".glb" else sorted(p for p in file.parent.rglob("*") if p.is_file())
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.relative_to(file.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _to_annotation_frame(frame: AnnotationFrame) -> FloatArray:
    """(4, 4) p_N = X_NA p_A, with its scale."""
    X_NA = np.eye(4)
    X_NA[:3, :3] /= frame.unit_m
    X_NA[:3, 3] = -np.asarray(frame.centre_m) / frame.unit_m
    return X_NA


def _cameras(views: Sequence[CameraView], extent: FloatArray) -> dict[str, dict[str, Any]]:
    cameras: dict[str, dict[str, Any]] = {}
    for view in views:
        lens, X_NC = camera(view, extent), np.eye(4)
        X_NC[:3, :3], X_NC[:3, 3] = lens.R_NC, lens.position
        cameras[view.name] = {"X_NC": X_NC.tolist(), "azimuth_deg": view.azimuth_deg}
    return cameras
