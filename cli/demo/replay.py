"""The replay part of the demo: an arm's motion gets new objects that it provably never touches."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.interpolate import CubicSpline
from shapely.geometry import MultiPoint
from shapely.geometry.base import BaseGeometry

from cli.replay.candidates import candidates
from cli.replay.picture import picture
from geom.convex.circumscribed_hull import circumscribed_hull
from geom.pose import apply
from jobs.cache import write_atomically
from replay.augmentation import prepare, variants
from replay.envelope.envelope import Settings
from replay.recording.formats.read import read_episode
from replay.recording.formats.write import write_variant
from replay.verification.check_output import check_output, summary
from replay.verification.inserted_bodies import inserted_body
from schemas.replay.documents import Variant
from schemas.replay.episode import EPISODE_FILE
from usdio.write.scene import PACKAGES, copy_package

VARIANTS, OBJECTS, SHOWN, ROWS = 6, 3, 3, 160
# Angles of the first six joints: home, to the left, down, up, to the right, down, home.
_WAYPOINTS = (
    (0.0, 0.3, 0.0, -2.2, 0.0, 2.5), (0.5, 0.55, 0.0, -2.0, 0.0, 2.55), (0.5, 0.8, 0.0, -1.95, 0.0, 2.75),
    (0.3, 0.4, 0.0, -2.1, 0.0, 2.5), (-0.6, 0.6, 0.0, -1.9, 0.0, 2.5), (-0.6, 0.82, 0.0, -1.85, 0.0, 2.7),
    (0.0, 0.3, 0.0, -2.2, 0.0, 2.5),
)  # fmt: skip
_STAYS = {"panda_joint7": 0.8, "panda_finger_joint1": 0.04, "panda_finger_joint2": 0.04}
_SCENE = {
    "robots": [{"name": "panda", "model": "panda.urdf"}],
    "objects": [],
    "fixtures": [
        {
            "name": "table",
            "position_m": [0.55, 0, -0.08],
            "shapes": [{"type": "box", "name": "tabletop", "size_m": [0.7, 1.0, 0.04]}],
        }
    ],
    "cameras": [
        {"name": "front", "fovy_deg": 45, "position_m": [1.6, 0, 0.9], "quat_wxyz": [0.6124, 0.3536, 0.3536, 0.6124]}
    ],
}


@dataclass(frozen=True)
class ReplayDemo:
    """What the verifier said of the variants, pictures by number beside the page, and what the envelope is made of."""

    folder: str
    verdict: dict[str, object]
    pictures: tuple[str, ...]
    capsules: int


def replay_demo(library: Path, arm: Path, out: Path) -> ReplayDemo | None:
    """Record, augment, verify and draw in `out/replay`; `arm` has panda.urdf. None where it or packages are absent."""
    if not (arm / "panda.urdf").is_file() or not any(library.glob("*/record.json")):
        return None
    folder = out / "replay"
    prepared = prepare(read_episode(_recording(folder / "recording", arm), arm), Settings())
    draw, _ = candidates(None, library)
    made = list(variants(prepared, draw, range(VARIANTS), OBJECTS, seed=0, packages=library))
    for variant in made:
        write_variant(prepared.episode, variant, folder / f"variant_{variant.number:04d}")
    for package in sorted({one.package for variant in made for one in variant.inserted if one.package}):
        copy_package(library / package, folder / PACKAGES / package)
    pictures = []
    for variant in made[:SHOWN]:
        file = folder / f"variant_{variant.number:04d}.png"
        write_atomically(file, picture(prepared, _outlines(variant, folder / PACKAGES)))
        pictures.append(file.relative_to(out).as_posix())
    verdict = summary(check_output(folder, folder / PACKAGES, None, meshes=arm))
    return ReplayDemo("replay", verdict, tuple(pictures), len(prepared.envelope.body))


def _recording(folder: Path, arm: Path) -> Path:
    """An episode folder: the arm of pybullet_data passes over the table on a smooth path of ours, stamps irregular."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(arm / "panda.urdf", folder / "panda.urdf")
    t_s = np.cumsum(np.random.default_rng(0).uniform(0.03, 0.07, ROWS))
    path = CubicSpline(np.linspace(t_s[0], t_s[-1], len(_WAYPOINTS)), _WAYPOINTS, bc_type="clamped")
    rows = {"t": t_s}
    for k in range(len(_WAYPOINTS[0])):
        rows |= {f"q.panda_joint{k + 1}": path(t_s)[:, k], f"qd.panda_joint{k + 1}": path(t_s, 1)[:, k]}
    for joint, angle in _STAYS.items():
        rows |= {f"q.{joint}": np.full(ROWS, angle), f"qd.{joint}": np.zeros(ROWS)}
    pq.write_table(pa.table(rows), folder / "episode.parquet")
    write_atomically(folder / EPISODE_FILE, json.dumps(_SCENE, indent=1).encode())
    return folder


def _outlines(variant: Variant, packages: Path) -> list[tuple[str, BaseGeometry]]:
    """Name and outline in W of each object put in."""
    outlines = []
    for one in variant.inserted:
        body = inserted_body(one, packages)
        corners = np.concatenate([apply(body.X_WA, circumscribed_hull(shape)) for shape in body.body.shapes])
        outlines.append((one.asset_id, MultiPoint(corners[:, :2]).convex_hull))
    return outlines
