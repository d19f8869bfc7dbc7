"""Draws the cameras of samples: poses and lenses within their ranges, such that each shows what it must.

A camera is drawn anew until its view shows each object of `visible` with the pixels demanded, at most `TRIES` times.
The numbers of try k of sample i depend on the seed, i and k alone. Metres, degrees where a name says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geom.pose import matrix_of, quat_of
from runtime_plan.camera_rays import visible_pixels
from runtime_plan.counter_rng import uniforms
from runtime_plan.plan import Plan
from runtime_plan.samples import Samples
from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, finding
from schemas.scene.camera_pose import CameraPose
from schemas.scene.cameras import Camera
from schemas.scene.geometry import BACKGROUND, Prism

TRIES = 256  # of one camera in one scene
SPARE_PIXELS = 1  # beyond the number demanded: rays along an edge may be counted either way
STREAM = 0x9E3779B97F4A7C15  # of cameras, added to the seed: they share no numbers with poses
LEVEL = 1e-6  # sine of the angle between line of sight and vertical below which a picture has no natural up


@dataclass(frozen=True)
class SceneBody:
    """A body of one scene in W: its pieces, origin (3,) and heading (rad) of its asset frame."""

    prisms: tuple[Prism, ...]
    origin_m: FloatArray
    yaw_rad: float

    @property
    def middle_m(self) -> FloatArray:
        """Middle (3,) of the box around its pieces."""
        points = np.concatenate([prism.outline_m for prism in self.prisms])
        low, high = min(prism.low_m for prism in self.prisms), max(prism.high_m for prism in self.prisms)
        return np.array([*(0.5 * (points.min(axis=0) + points.max(axis=0))), 0.5 * (low + high)])


def draw_cameras(plan: Plan, samples: Samples, k: int) -> dict[str, CameraPose]:
    """The cameras of sample k by id. Raises InvalidInput (`plan/no-view`) where no try shows what it must."""
    cameras = plan.document.cameras
    if not cameras:
        return {}
    bodies = bodies_of(plan, samples, k)
    drawn: dict[str, CameraPose] = {}
    for number, camera in enumerate(cameras):
        pose = view(camera, number, bodies, samples.seed, samples.start + k)
        if pose is None:
            text = f"no camera `{camera.id}` in {TRIES} tries shows what it must in sample {samples.start + k}"
            raise InvalidInput(finding("plan/no-view", text, value=TRIES, unit="tries"))
        drawn[camera.id] = pose
    return drawn


def view(camera: Camera, number: int, bodies: Mapping[str, SceneBody], seed: int, index: int) -> CameraPose | None:
    """The first drawn pose of camera `number` that shows what it must in scene `index`; None when none does."""
    draws = uniforms((seed + STREAM * (number + 1)) % 2**64, index * TRIES, TRIES, 2)
    for u in draws:
        pose = pose_of_camera(camera, bodies, u)
        if all(_sees(pose, bodies, rule.object, rule.pixels + SPARE_PIXELS) for rule in camera.visible):
            return pose
    return None


def _sees(pose: CameraPose, bodies: Mapping[str, SceneBody], name: str, pixels: int) -> bool:
    others = [prism for other, body in bodies.items() if other != name for prism in body.prisms]
    return visible_pixels(pose, bodies[name].prisms, others) >= pixels


def pose_of_camera(camera: Camera, bodies: Mapping[str, SceneBody], u: Sequence[float] | FloatArray) -> CameraPose:
    """The pose at six numbers from 0 to 1: position along x, y and z, roll, field of view; the last is not used."""
    ranges = (camera.position.x, camera.position.y, camera.position.z, camera.roll_deg, camera.fov_deg)
    x, y, z, roll_deg, fov_deg = (low + float(v) * (high - low) for (low, high), v in zip(ranges, u, strict=False))
    at = _in_world(camera, bodies, np.array([x, y, z]))
    if isinstance(camera.look_at, str):
        aim = bodies[camera.look_at].middle_m
    else:
        aim = _in_world(camera, bodies, np.array(camera.look_at))
    ahead = (aim - at) / max(float(np.linalg.norm(aim - at)), LEVEL)
    right = np.array([ahead[1], -ahead[0], 0.0])
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > LEVEL else np.array([1.0, 0.0, 0.0])
    up = np.cross(right, ahead)
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    R_WC = np.column_stack([c * right + s * up, c * up - s * right, -ahead])
    a, b, d, e = (float(q) for q in quat_of(R_WC))
    return CameraPose(
        position_m=(float(at[0]), float(at[1]), float(at[2])), quat_wxyz=(a, b, d, e), fov_deg=fov_deg, size=camera.size
    )


def _in_world(camera: Camera, bodies: Mapping[str, SceneBody], point: FloatArray) -> FloatArray:
    if camera.relative_to is None:
        return point
    body = bodies[camera.relative_to]
    c, s = np.cos(body.yaw_rad), np.sin(body.yaw_rad)
    x, y, z = point
    return body.origin_m + np.array([c * x - s * y, s * x + c * y, z])


def bodies_of(plan: Plan, samples: Samples, k: int) -> dict[str, SceneBody]:
    """The bodies of sample k by name, the background included."""
    return dict(_bodies(plan, samples, k))


def _bodies(plan: Plan, samples: Samples, k: int) -> Iterator[tuple[str, SceneBody]]:
    document = plan.document
    combination = document.combinations[int(samples.combination[k])]
    if combination.background is not None:
        X_WB = np.array(combination.X_WB)
        X_WB[2, 3] += samples.rise_m[k]
        yaw = float(np.arctan2(X_WB[1, 0], X_WB[0, 0]))
        stance = document.bodies[combination.background].stances[0]
        yield BACKGROUND, _placed(stance.prisms, stance.origin_height_m, X_WB[:3, 3], yaw)
    for column in np.flatnonzero(samples.present[k]).tolist():
        stance = document.bodies[int(samples.asset_index[k, column])].stances[int(samples.stance[k, column])]
        turn = matrix_of(samples.quat_wxyz[k, column]) @ matrix_of(np.asarray(stance.quat_wxyz)).T
        yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
        yield (
            samples.names[column],
            _placed(stance.prisms, stance.origin_height_m, samples.position_m[k, column], yaw),
        )


def _placed(prisms: Sequence[Prism], height_m: float, origin_m: FloatArray, yaw_rad: float) -> SceneBody:
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    turn_T, floor_m = np.array([[c, s], [-s, c]]), float(origin_m[2]) - height_m
    pieces = tuple(
        Prism(prism.outline_m @ turn_T + origin_m[:2], floor_m + prism.low_m, floor_m + prism.high_m)
        for prism in prisms
    )
    return SceneBody(pieces, np.asarray(origin_m), yaw_rad)
