"""PNG pictures of a canonical model with its colliders, parts, grasps or joints, drawn in a child process.

Graphics drivers crash; the process that makes the asset must not crash with them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from assetkit.storage import require_storage
from geom.mechanism_pose import link_motions
from jobs.cell import Limits
from jobs.warm import run_module
from render.camera import STANDARD_VIEWS
from render.drawn_grasp import DrawnGrasp
from render.modes.request import ModeRequest
from render.motion_request import MotionRequest
from render.request import RenderRequest
from schemas.arrays import FloatArray, IntArray
from schemas.files import array_files
from schemas.model import Model
from schemas.parts import Part
from schemas.physics import CollisionShape

T = TypeVar("T")
MOTION_PX = 512
VIEW_PX = 512
LIMITS = Limits(seconds=120.0, memory_mb=6144)


def render_previews(
    model: Model,
    shapes: tuple[CollisionShape, ...],
    work_dir: Path,
    parts: Sequence[Part] = (),
    grasps: tuple[DrawnGrasp, ...] = (),
    *,
    joints: bool = False,
) -> dict[str, bytes]:
    """PNG bytes by name, of a canonical model, its collision shapes and its parts; with `grasps` only one of those.

    With `joints` a model that has a mechanism is also drawn with its joints opened by 0, 50 and 100 %.

    Raises RuntimeError when the renderer fails, OSError when files could not be written or read: a broken environment,
    not a bad asset.
    """
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        legend, part_of = shown_parts(model, parts)
        request = RenderRequest(model, shapes, place, grasps=grasps, parts=legend, part_of=part_of, joints=joints)
        return {p.stem: p.read_bytes() for p in _drawn(request, RenderRequest, "previews", Path(place))}


def render_mode(request: ModeRequest) -> list[Path]:
    """Draws a request of a mode; the pictures in its folder. Raises as `render_previews`."""
    with tempfile.TemporaryDirectory(dir=request.out_dir) as place:
        drawn = _drawn(replace(request, out_dir=place), ModeRequest, "mode", Path(place))
        return [picture.replace(Path(request.out_dir) / picture.name) for picture in drawn]


def render_views(
    model: Model, box_m: tuple[FloatArray, FloatArray], work_dir: Path, size_px: int = VIEW_PX
) -> dict[str, bytes]:
    """PNG bytes of the standard views of a model by name, framed by the box between two corners (3,).

    Models in the same box are seen by the same cameras. Raises as `render_previews`.
    """
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        request = RenderRequest(model, (), place, size_px, box_m=box_m)
        pictures = {p.stem: p.read_bytes() for p in _drawn(request, RenderRequest, "previews", Path(place))}
    return {view.name: pictures[view.name] for view in STANDARD_VIEWS}


def render_joints(model: Model, positions: Sequence[Mapping[str, float]], work_dir: Path) -> list[bytes]:
    """PNG bytes of a canonical model with a mechanism, one picture for each of the joint positions by name (rad, m).

    Raises as `render_previews`.
    """
    if model.mechanism is None:
        raise ValueError("the model has no mechanism")
    poses = [link_motions(model.mechanism, given) for given in positions]
    return render_motion(model, {name: np.stack([each[name] for each in poses]) for name in poses[0]}, work_dir)


def render_motion(
    model: Model, motions: Mapping[str, FloatArray], work_dir: Path, size_px: int = MOTION_PX
) -> list[bytes]:
    """PNG bytes of a canonical model, one picture for each of the motions (k, 4, 4) by the name of a link.

    Raises as `render_previews`.
    """
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        request = MotionRequest(model, dict(motions), place, size_px)
        return [p.read_bytes() for p in _drawn(request, MotionRequest, "motion", Path(place))]


def _drawn(request: T, kind: type[T], what: str, place: Path) -> list[Path]:
    """The pictures of a request of `render`, which names the folder `place` for them."""
    file = place / "request.npz"
    array_files.save(request, kind, file)
    result = run_module("render", [what, str(file)], LIMITS)
    require_storage(result)
    if result.status != "ok":
        raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
    return sorted(place.glob("*.png"))


def shown_parts(model: Model, parts: Sequence[Part]) -> tuple[tuple[str, ...], IntArray]:
    """A legend line per label, most confident first, and the line of each triangle (m,): that of its smallest part."""
    sure = {p.label.value: max(q.label.confidence for q in parts if q.label.value == p.label.value) for p in parts}
    order = sorted(sure, key=lambda label: (-sure[label], label))
    count = {label: sum(p.label.value == label for p in parts) for label in order}
    lines = [f"{label} x{count[label]}" if count[label] > 1 else label for label in order]
    legend = tuple(f"{line}  {sure[name]:.2f}" if sure[name] else line for line, name in zip(lines, order, strict=True))
    of_mesh = []
    for mesh_id, mesh in model.meshes_by_id.items():
        index = np.full(len(mesh.triangles), -1, dtype=np.int64)
        for part in sorted(parts, key=lambda p: -p.area_m2):
            known = part.label.confidence > 0.0
            mask = part.mask(mesh_id, len(index))
            # An unlabelled region within a labelled one would hide its colour.
            index[mask if known else mask & (index == -1)] = order.index(part.label.value)
        of_mesh.append(index)
    return legend, np.concatenate(of_mesh) if of_mesh else np.zeros(0, dtype=np.int64)
