"""A GIF of what the suites of acceptance did with a package: the gripper that carries it, or moves its joints.

The motions are those that were simulated (`sim.grasp_trial.GraspTrace`, `sim.joint_handling.HandlingTrace`), the object
is drawn with its own materials, the gripper as the boxes that it was in the simulation.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from assetkit.library.animate_joints import forward_gif
from assetkit.package.preview_images import render_motion
from geom.mechanism_pose import link_motions
from geom.mesh.primitives import cube
from jobs.cache import write_atomically
from schemas.appearance.material import Material
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism
from schemas.model import Mesh, Model
from sim.grasp_trial import GraspTrace
from sim.joint_handling import HandlingTrace

VIDEO_PX, MOST_FRAMES = 600, 60  # before empty margins are cut off
LEAST_FRAME_MS = 80  # at least: faster and viewers of GIFs stumble
_EMPTY_STEP, _MARGIN_PX = 40, 12  # of 255 from the corner of the pictures: not even a soft shadow; around what moves
BOXES = ("gripper left finger", "gripper right finger", "gripper hand")
_FINGER, _HAND = (0.80, 0.30, 0.05), (0.12, 0.14, 0.17)  # linear RGB


def write_video(
    model: Model,
    grasp: GraspTrace | None,
    handled: Sequence[HandlingTrace],
    out: Path,
    *,
    frames: int = MOST_FRAMES,
    size_px: int = VIDEO_PX,
) -> Path | None:
    """Write the GIF `out` of the grasp and of the joints one after the other; None, and nothing, without any motion.

    About `frames` pictures; `model` is canonical, in the frame of the traces. Raises RuntimeError when the renderer
    fails.
    """
    links = tuple(dict.fromkeys(mesh.link for mesh in model.meshes))
    pieces = [] if grasp is None else [_carried(links, grasp)]
    pieces += [] if model.mechanism is None else [_opened(links, model.mechanism, trace) for trace in handled]
    rows = sum(len(times_s) for times_s, _ in pieces)
    if not rows:
        return None
    every = max(rows / frames, 1.0)
    shown: dict[str, list[FloatArray]] = {name: [] for name in (*links, *BOXES)}
    for times_s, motions in pieces:
        chosen = np.unique(np.append(np.arange(0.0, len(times_s) - 1, every).astype(int), len(times_s) - 1))
        for name, each in motions.items():
            shown[name].append(each[chosen])
    motions = {name: np.concatenate(parts) for name, parts in shown.items()}
    out.parent.mkdir(parents=True, exist_ok=True)
    pictures = cropped(render_motion(with_gripper(model), motions, out.parent, size_px))
    step_ms = 1000.0 * float(np.mean([np.diff(times_s).mean() for times_s, _ in pieces]))
    write_atomically(out, forward_gif(pictures, max(round(every * step_ms), LEAST_FRAME_MS)))
    return out


def cropped(pictures: Sequence[bytes]) -> list[bytes]:
    """PNG pictures of one size without the margins in which none of them shows anything."""
    images = [Image.open(io.BytesIO(data)).convert("RGB") for data in pictures]
    shown = np.zeros((images[0].height, images[0].width), dtype=bool)
    for image in images:
        pixels = np.asarray(image).astype(np.int64)
        shown |= np.abs(pixels - pixels[0, 0]).max(axis=2) > _EMPTY_STEP
    rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
    if not len(rows):
        return list(pictures)
    box = (
        max(int(columns[0]) - _MARGIN_PX, 0),
        max(int(rows[0]) - _MARGIN_PX, 0),
        min(int(columns[-1]) + 1 + _MARGIN_PX, shown.shape[1]),
        min(int(rows[-1]) + 1 + _MARGIN_PX, shown.shape[0]),
    )
    parts = list[bytes]()
    for image in images:
        file = io.BytesIO()
        image.crop(box).save(file, "PNG", compress_level=1)
        parts.append(file.getvalue())
    return parts


def with_gripper(model: Model) -> Model:
    """The model with the three boxes of a gripper, each a cube of 1 m of its own link at the origin."""
    first = len(model.materials)
    points, triangles, normals = cube(1.0)
    meshes = [
        Mesh(
            name,
            points,
            triangles.astype(np.int32),
            normals.astype(np.float32),
            material=first + (name == BOXES[2]),
            id=name,
            link=name,
        )
        for name in BOXES
    ]
    materials = (Material("finger", base_color=_FINGER, roughness=0.6), Material("hand", base_color=_HAND))
    return replace(model, meshes=(*model.meshes, *meshes), materials=(*model.materials, *materials))


def _carried(links: Sequence[str], trace: GraspTrace) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Seconds (k,) and motions (k, 4, 4) by link of a body that is carried."""
    return trace.times_s, {**dict.fromkeys(links, trace.X_WA), **_boxes(trace.X_WB, trace.half_m)}


def _opened(
    links: Sequence[str], mechanism: Mechanism, trace: HandlingTrace
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Seconds (k,) and motions (k, 4, 4) by link of an object with a joint that is moved."""
    poses = [link_motions(mechanism, {trace.joint: float(q)}) for q in trace.positions]
    motions: Mapping[str, FloatArray] = {name: np.stack([each[name] for each in poses]) for name in links}
    return trace.times_s, {**motions, **_boxes(trace.X_AB, trace.half_m)}


def _boxes(X_WB: FloatArray, half_m: FloatArray) -> dict[str, FloatArray]:
    """Motions (k, 4, 4) that make cubes of 1 m at the origin the boxes at X_WB (k, 3, 4, 4)."""
    size = np.stack([np.diag([*2.0 * half, 1.0]) for half in half_m])
    return {name: X_WB[:, b] @ size[b] for b, name in enumerate(BOXES)}
