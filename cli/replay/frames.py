"""A variant drawn as its recorded cameras see it, each camera in a process of its own."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.readers.common.images import load_texture
from cli import text
from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.warm import run_module
from render.frames_request import DrawnBody, DrawnModel, FramesRequest
from replay.recording.episode import Camera, Episode
from replay.recording.recorded_numbers import invalid_recording
from replay.variant_stage import timed_bodies, write_stage
from replay.verification.check_output import read_variant, read_variant_episode
from schemas.files import array_files
from schemas.replay.documents import Variant
from schemas.scene.samples import SampledLighting
from usdio.read.asset import read_stage
from usdio.write.episode import COLORS, CONTEXT, INSERTED, inserted_prims
from usdio.write.light_color import light_color

FRAMES = "frames.json"
_LIMITS = Limits(seconds=12 * 3600.0, memory_mb=8192)


class NoSuchCamera(Exception):
    """The recording has no camera of that name, or none at all; the message names those it has."""


def draw_variant(
    folder: Path, out: Path, assets: Path | None, meshes: Path | None, cameras: Sequence[str], every: int, quiet: bool
) -> dict[str, int | float | str]:
    """Compose the variant, draw rows 0, `every`, ... of its cameras, by default of all; returns what was made.

    Raises InvalidInput, NoSuchCamera, and RuntimeError when the renderer fails.
    """
    described = read_variant(folder)
    episode = read_variant_episode(folder, described, meshes)
    chosen = _chosen(episode, cameras)
    write_stage(folder, described, episode, assets)
    rows = np.arange(0, len(episode.t_s), every)
    bodies, models, names = _things(folder, described, episode, rows)
    started = time.monotonic()
    with text.progress(quiet=quiet) as bar:
        task = bar.add_task("drawing", total=len(chosen))
        for camera in chosen:
            _draw(_request(camera, rows, bodies, models, described, _folder(out, camera)))
            bar.advance(task)
    frames = len(rows) * len(chosen)
    about = {
        "schema_version": "1.0",
        "episode": described.episode,
        "variant": described.number,
        "depth_unit_m": 0.001,
        "instances": names,
        "cameras": {camera.name: _lens(camera, episode, rows) for camera in chosen},
    }
    write_atomically(out / FRAMES, (json.dumps(about, indent=1) + "\n").encode())
    return {"frames": frames, "frames_per_s": round(frames / (time.monotonic() - started), 1), "out": str(out)}


def _folder(out: Path, camera: Camera) -> Path:
    """Where its pictures go. Raises InvalidInput where the name that the recording gives it leads out of `out`."""
    if not (out / camera.name).resolve().is_relative_to(out.resolve()):
        raise invalid_recording(
            "replay/path-escape", f"pictures of a camera called '{camera.name}' would not lie below --out"
        )
    return out / camera.name


def _chosen(episode: Episode, named: Sequence[str]) -> tuple[Camera, ...]:
    """Raises NoSuchCamera."""
    known = {camera.name: camera for camera in episode.cameras}
    words = list(named) or list(known)
    for word in words or [""]:
        if word not in known:
            raise NoSuchCamera(f"the recording has no camera '{word}' (it has {', '.join(known) or 'none'})")
    return tuple(known[word] for word in words)


def _things(
    folder: Path, variant: Variant, episode: Episode, rows: np.ndarray
) -> tuple[tuple[DrawnBody, ...], tuple[DrawnModel, ...], dict[str, dict[str, str]]]:
    """What is drawn, and by their number what the things are called; numbers start at 1, links count one by one."""
    bodies: list[DrawnBody] = []
    names: dict[str, dict[str, str]] = {}
    for body in timed_bodies(episode):
        if body.shapes:
            number = len(names) + 1
            names[str(number)] = {"name": body.name, "kind": body.group.lower().rstrip("s"), "robot": body.owner}
            X_WB = body.X_WB if len(body.X_WB) == 1 else body.X_WB[rows]
            bodies.append(DrawnBody(number, body.shapes, _color(body.group, number), X_WB))
    models: list[DrawnModel] = []
    if variant.inserted:
        model = read_stage(folder / CONTEXT, folder, load_texture=load_texture).value
        assert model is not None, "our own stage can be read"
        for prim, inserted in zip(
            inserted_prims([one.name for one in variant.inserted]), variant.inserted, strict=True
        ):
            number = len(names) + 1
            names[str(number)] = {"name": inserted.name, "kind": "inserted", "asset": inserted.asset_id}
            own = tuple(m for m in model.meshes if m.source_path.startswith(f"{INSERTED}/{prim}/"))
            models.append(DrawnModel(number, replace(model, meshes=own)))
    return tuple(bodies), tuple(models), names


def _color(group: str, number: int) -> tuple[float, float, float]:
    """Linear RGB; what stands differs in shade, so that a table differs from the floor (golden-ratio steps)."""
    shade = 0.4 + 0.6 * (number * 0.618 % 1.0) if group == "Fixtures" else 1.0
    red, green, blue = (shade * channel for channel in COLORS[group])
    return red, green, blue


def _request(
    camera: Camera,
    rows: np.ndarray,
    bodies: tuple[DrawnBody, ...],
    models: tuple[DrawnModel, ...],
    variant: Variant,
    folder: Path,
) -> FramesRequest:
    drawn = SampledLighting.model_validate(variant.lights) if variant.lights else None
    light = light_color(drawn)
    return FramesRequest(
        X_WC=camera.X_WC[rows],
        fovy_rad=float(camera.fovy_rad),
        width_px=camera.width_px,
        height_px=camera.height_px,
        rows=tuple(rows.tolist()),
        bodies=bodies,
        models=models,
        out_dir=str(folder),
        lamp=light,
        dome=light,
        dome_rad=(drawn.rotation or 0.0) if drawn is not None else 0.0,
    )


def _draw(request: FramesRequest) -> None:
    """In a child process. Raises RuntimeError when the renderer fails: a broken environment, not a bad recording."""
    with tempfile.TemporaryDirectory(prefix="mana") as place:
        file = Path(place) / "request.npz"
        array_files.save(request, FramesRequest, file)
        result = run_module("render", ["frames", str(file)], _LIMITS)
    if result.status != "ok":
        raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")


def _lens(camera: Camera, episode: Episode, rows: np.ndarray) -> dict[str, object]:
    """Lens (pixels) and the files of one camera with stamps and poses."""
    focal_px = camera.height_px / 2.0 / float(np.tan(camera.fovy_rad / 2.0))
    frames = [
        {"row": row, "t_s": float(episode.t_s[row]), "file": f"{row:06d}.png", "X_WC": camera.X_WC[row].tolist()}
        for row in rows.tolist()
    ]
    return {
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "focal_px": focal_px,
        "centre_px": [camera.width_px / 2.0, camera.height_px / 2.0],
        "frames": frames,
    }
