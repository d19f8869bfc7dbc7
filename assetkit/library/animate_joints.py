"""A GIF of an articulated object whose joints move from one end of their range to the other and back."""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from assetkit.package.preview_images import render_joints
from geom.mechanism_pose import movable_joints, opened
from jobs.cache import write_atomically
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.mechanism import MechanismJoint
from schemas.model import Model

_FRAME_MS, _END_MS = 60, 600
_PALETTE_FRAMES = 4  # of which the colours of all frames are taken


def animate_joints(model: Model, out: Path, frames: int, names: Sequence[str], source: str) -> Path:
    """Write the GIF `out`: `frames` pictures from the least to the greatest opening, then back; returns its path.

    The joints of `names` move, or all without names; the others are at rest or follow. `source` names the file in
    findings. Raises InvalidInput (`asset/missing-joint`) where there is nothing to move.
    """
    joints = _chosen(model, names, source)
    # A cosine starts and ends gently.
    shares = [0.5 - 0.5 * math.cos(math.pi * k / (frames - 1)) for k in range(frames)]
    out.parent.mkdir(parents=True, exist_ok=True)
    pictures = render_joints(model, [opened(joints, share) for share in shares], out.parent)
    write_atomically(out, looped_gif(pictures))
    return out


def looped_gif(pictures: Sequence[bytes]) -> bytes:
    """A GIF that shows PNG `pictures` forward and back without end."""
    there = _opened(pictures)
    return _gif([*there, *there[-2:0:-1]], {0, len(there) - 1}, _FRAME_MS)


def forward_gif(pictures: Sequence[bytes], frame_ms: int) -> bytes:
    """A GIF that shows PNG `pictures` forward without end, and waits at the last one."""
    there = _opened(pictures)
    return _gif(there, {len(there) - 1}, frame_ms)


def _opened(pictures: Sequence[bytes]) -> list[Image.Image]:
    return [Image.open(io.BytesIO(data)).convert("RGB") for data in pictures]


def _gif(there: Sequence[Image.Image], waits: Collection[int], frame_ms: int) -> bytes:
    """Pictures in order, each for `frame_ms`, those that wait for longer; one palette, so that nothing flickers."""
    sample = np.linspace(0, len(there) - 1, min(_PALETTE_FRAMES, len(there))).round().astype(int)
    montage = Image.fromarray(np.concatenate([np.asarray(there[k]) for k in sample]))
    palette = montage.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    images = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in there]
    durations_ms = [_END_MS if k in waits else frame_ms for k in range(len(images))]
    file = io.BytesIO()
    images[0].save(file, "GIF", save_all=True, append_images=images[1:], duration=durations_ms, loop=0, optimize=False)
    return file.getvalue()


def _chosen(model: Model, names: Sequence[str], source: str) -> list[MechanismJoint]:
    movable = () if model.mechanism is None else movable_joints(model.mechanism)
    where = Location(file=source)
    if not movable:
        raise InvalidInput(finding("asset/missing-joint", "a rigid object has no joints to move", where=where))
    unknown = [n for n in names if all(n not in (joint.name, joint.source_name) for joint in movable)]
    if unknown:
        listed = ", ".join(joint.name for joint in movable)
        headline = f"no joint '{unknown[0]}' moves on its own here; those that do: {listed}"
        raise InvalidInput(finding("asset/missing-joint", headline, where=where, value=unknown[0]))
    return [joint for joint in movable if not names or joint.name in names or joint.source_name in names]
