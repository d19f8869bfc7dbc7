"""Build an episode from streams by name and a description of their bodies. All table formats end here.

Streams: `q.<joint>` or `q.<robot>.<joint>`, `qd...` likewise; `base.<robot>`, `obj.<object>`, `cam.<camera>` with
`.px .py .pz .qw .qx .qy .qz` behind.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from geom.pose import apply, pose_from_quat
from replay.recording.description.robot_links import read_robot_links
from replay.recording.episode import Camera, Episode, Fixture, FreeBody, Robot
from replay.recording.files.archives import read_arrays
from replay.recording.files.tables import Columns, column_poses
from replay.recording.kinematics import link_poses
from replay.recording.mjcf.bodies import RecordedBodies, is_free
from replay.recording.mjcf.episode_parts import episode_parts, trees
from replay.recording.mjcf.meshes import MeshFiles
from replay.recording.recorded_numbers import RecordedStates, checked_numbers, checked_stamps, invalid_recording
from replay.recording.robot_files import recorded_mjcf
from replay.recording.shapes import hull, locate_mesh, mesh_points
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from schemas.replay.episode import EpisodeDescription, MeshShape, Posed, RobotEntry, RoundShape, Shape, SphereShape


def read_description(path: Path) -> EpisodeDescription:
    """The description in a file. Raises InvalidInput."""
    try:
        return EpisodeDescription.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        raise invalid_recording("replay/missing-file", f"'{path.name}' is absent", path.name) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise invalid_recording("replay/invalid-value", f"{where}: {first['msg']}", path.name) from None


class DescribedRecording:
    """A description, the folder of its relative paths, and the streams of one recording."""

    def __init__(
        self, description: EpisodeDescription, folder: Path, columns: Columns, file: str, meshes: Path | None = None
    ) -> None:
        self.description, self.folder, self.file, self.meshes = description, folder, file, meshes
        self.columns = columns
        if "t" not in columns:
            raise invalid_recording("replay/missing-column", "no column 't'", file)
        self.t_s = checked_stamps(columns["t"], file)
        for name, values in columns.items():
            if len(values) != len(self.t_s):
                raise invalid_recording(
                    "replay/state-size", f"{len(values)} values of '{name}' for {len(self.t_s)} stamps", file
                )

    def episode(self, name: str, source: Path, part: str = "") -> Episode:
        """The episode. Raises InvalidInput."""
        robots = tuple(self._robot(entry) for entry in self.description.robots)
        objects = tuple(
            FreeBody(o.name, self._poses(f"obj.{o.name}"), tuple(self._shape(s, o.name) for s in o.shapes))
            for o in self.description.objects
        )
        fixtures = tuple(
            Fixture(
                f.name,
                _pose(f, self.file),
                tuple(self._shape(s, f.name) for s in f.shapes),
                tuple(s.name or (f.name if len(f.shapes) == 1 else f"{f.name}_{k}") for k, s in enumerate(f.shapes)),
            )
            for f in self.description.fixtures
        )
        return Episode(name, source, self.t_s, robots, objects, fixtures, self._cameras(robots), part)

    def _stream(self, kind: str, robot: str, joint: str) -> FloatArray | None:
        for name in (f"{kind}.{robot}.{joint}", f"{kind}.{joint}"):
            if name in self.columns:
                return checked_numbers(self.columns[name], name, self.file)
        return None

    def _poses(self, name: str) -> FloatArray:
        return column_poses(self.columns, name, self.file)

    def _robot(self, entry: RobotEntry) -> Robot:
        n = len(self.t_s)
        moves = f"base.{entry.name}.px" in self.columns
        X_WR = self._poses(f"base.{entry.name}") if moves else np.tile(_pose(entry, self.file), (n, 1, 1))
        path = self.folder / entry.model
        if path.suffix.lower() in (".xml", ".mjcf"):
            return self._robot_of_mjcf(entry, path, X_WR)
        model = read_robot_links(
            path, self.folder, self.meshes, lambda joint: self._stream("q", entry.name, joint) is not None
        )
        q = np.stack([self._position(entry, joint) for joint in model.coordinates] or [np.zeros(n)], axis=1)
        rates = [self._rate(entry, joint) for joint in model.coordinates]
        known = [rate for rate in rates if rate is not None]
        qd = np.stack(known, axis=1) if known and len(known) == len(rates) else None
        return Robot(entry.name, model.links, model.coordinates, X_WR, q[:, : len(model.coordinates)], qd)

    def _position(self, entry: RobotEntry, joint: str) -> FloatArray:
        recorded = self._stream("q", entry.name, joint)
        if recorded is not None:
            return recorded
        if joint not in entry.positions:
            message = f"joint '{joint}' of '{entry.name}' was not recorded and has no fixed position"
            raise invalid_recording("replay/missing-column", message, self.file)
        return np.full(len(self.t_s), entry.positions[joint])

    def _rate(self, entry: RobotEntry, joint: str) -> FloatArray | None:
        still = self._stream("q", entry.name, joint) is None and joint in entry.positions
        return np.zeros(len(self.t_s)) if still else self._stream("qd", entry.name, joint)

    def _robot_of_mjcf(self, entry: RobotEntry, path: Path, X_WR: FloatArray) -> Robot:
        """The one tree with joints of a MuJoCo file, its root where the file has it in the frame of the base."""
        model = RecordedBodies(recorded_mjcf(path, self.folder))
        moving = [t for t in trees(model) if any(not is_free(j) for b in t for j in model.joints[b])]
        if len(moving) != 1:
            raise invalid_recording(
                "replay/invalid-value", f"{len(moving)} trees with joints in '{path.name}', not one", path.name
            )
        joints = [j.name for b in moving[0] for j in model.joints[b] if not is_free(j)]
        rates = {joint: rate for joint in joints if (rate := self._rate(entry, joint)) is not None}
        root = moving[0][0]
        recorded = RecordedStates(
            self.t_s, {j: self._position(entry, j) for j in joints}, rates, {model.links[root].name: X_WR}
        )
        robots, _, _ = episode_parts(model, recorded, MeshFiles(model, self.folder, self.meshes).points)
        free = any(is_free(joint) for joint in model.joints[root])
        return replace(robots[0], name=entry.name, X_WR=X_WR if free else X_WR @ model.X_PB[root])

    def _shape(self, shape: Shape, body: str) -> CollisionShape:
        X = _pose(shape, self.file)
        if isinstance(shape, MeshShape):
            return hull(apply(X, self._points(shape)), shape.name or body, self.file)
        if isinstance(shape, SphereShape):
            return CollisionShape("sphere", (shape.radius_m,), X)
        if isinstance(shape, RoundShape):
            return CollisionShape(shape.type, (shape.radius_m, shape.height_m), X)
        return CollisionShape("box", shape.size_m, X)

    def _points(self, shape: MeshShape) -> FloatArray:
        if not shape.key:
            return mesh_points(locate_mesh(shape.file, self.folder, self.meshes, self.file), shape.scale, self.file)
        path = self.folder / shape.file
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise invalid_recording("replay/path-escape", f"'{shape.file}' lies outside the folder", self.file)
        found = read_arrays(path, lambda key: key == shape.key) if path.is_file() else {}
        if shape.key not in found:
            raise invalid_recording("replay/missing-mesh", f"no '{shape.key}' in '{shape.file}'", self.file)
        points = checked_numbers(found[shape.key], shape.key, shape.file)
        if points.ndim != 2 or points.shape[1] != 3:
            raise invalid_recording(
                "replay/bad-mesh", f"'{shape.key}' of '{shape.file}' is {points.shape}, not (n, 3)", self.file
            )
        return points * shape.scale

    def _cameras(self, robots: tuple[Robot, ...]) -> tuple[Camera, ...]:
        cameras = []
        for entry in self.description.cameras:
            if f"cam.{entry.name}.px" in self.columns:
                X_WC = self._poses(f"cam.{entry.name}")
            elif entry.robot or entry.link:
                X_WC = self._link(robots, entry.robot, entry.link) @ _pose(entry, self.file)
            else:
                X_WC = np.tile(_pose(entry, self.file), (len(self.t_s), 1, 1))
            fovy_rad = float(np.radians(entry.fovy_deg))
            cameras.append(Camera(entry.name, X_WC, fovy_rad, entry.width_px, entry.height_px))
        return tuple(cameras)

    def _link(self, robots: tuple[Robot, ...], name: str, link: str) -> FloatArray:
        for robot in robots:
            names = [one.name for one in robot.links]
            if name in ("", robot.name) and link in names:
                return link_poses(robot, robot.q, robot.X_WR)[:, names.index(link)]
        raise invalid_recording(
            "replay/invalid-value", f"a camera hangs on link '{link}' of '{name}', which is not there", self.file
        )


def _pose(posed: Posed, file: str) -> FloatArray:
    try:
        return pose_from_quat(np.array(posed.quat_wxyz), posed.position_m)
    except ValueError:
        raise invalid_recording("replay/invalid-value", "a quaternion of zeros is no orientation", file) from None


def rename_columns(columns: Columns, names: dict[str, str], file: str) -> Columns:
    """The columns, and under each new name the column `name` or entry `name[k]` of a vector. Raises InvalidInput."""
    out = dict(columns)
    for new, old in names.items():
        name, _, index = old.partition("[")
        if name not in columns:
            raise invalid_recording("replay/missing-column", f"no column '{name}' for '{new}'", file)
        values = columns[name]
        if index:
            number = int(index.rstrip("]")) if index.rstrip("]").isdigit() else -1
            if values.ndim != 2 or not 0 <= number < values.shape[1]:
                raise invalid_recording(
                    "replay/missing-column", f"'{old}' for '{new}': the column is {values.shape}", file
                )
            values = values[:, number]
        out[new] = values
    return out


def pose_columns(name: str, rows: FloatArray) -> Columns:
    """Columns `<name>.px ... qz` of rows [position, quaternion wxyz] (n, 7)."""
    return {f"{name}.{c}": rows[:, k] for k, c in enumerate(("px", "py", "pz", "qw", "qx", "qy", "qz"))}
