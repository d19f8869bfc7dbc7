"""Read a MuJoCo model file as bodies, joints, geoms and cameras (m, rad), in MuJoCo's order of numbers.

Format: mujoco.readthedocs.io/en/stable/XMLreference.html. Read are kinematic trees with defaults, frames and includes
of the same folder; anything that would silently be missing (composites, ball joints, ...) stops the reading.
Frames: B body, P its parent, G geom, C camera.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from geom.pose import pose
from replay.recording.mjcf.text import Attributes, Orientations, defaults_of, numbers, parse_mjcf
from replay.recording.recorded_numbers import invalid_recording
from schemas.arrays import FloatArray

_NOT_READ = ("composite", "flexcomp", "replicate", "attach", "plugin")
_GEOMS = ("plane", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")


@dataclass(frozen=True)
class MjJoint:
    """Position q moves the body by (q - reference) along or about `axis_B` through `anchor_B`."""

    name: str
    kind: Literal["hinge", "slide", "free"]
    axis_B: FloatArray
    anchor_B: FloatArray
    reference: float


@dataclass(frozen=True)
class MjGeom:
    """`size_m` as MuJoCo has it: half lengths, radii. `collides`: it takes part in contacts at all.

    `number` counts the geoms of the model as MuJoCo does, body by body.
    """

    name: str
    kind: str
    size_m: tuple[float, ...]
    X_BG: FloatArray
    mesh: str
    collides: bool
    number: int = -1


@dataclass(frozen=True)
class MjCamera:
    """A camera that is fixed to a body and looks along -z."""

    name: str
    X_BC: FloatArray
    fovy_rad: float


@dataclass
class MjBody:
    """A body; the world is the first, with parent -1."""

    name: str
    parent: int
    X_PB: FloatArray
    joints: list[MjJoint] = field(default_factory=list)
    geoms: list[MjGeom] = field(default_factory=list)
    cameras: list[MjCamera] = field(default_factory=list)


@dataclass(frozen=True)
class MjMesh:
    """A mesh asset: file as written, below `folder` as written; vertices times `scale` are in the frame of its geom."""

    file: str
    folder: str
    scale: tuple[float, ...]


@dataclass(frozen=True)
class MjModel:
    """Bodies in depth-first order, which is also that of their joints in the state vector; mesh assets by name."""

    file: str
    bodies: tuple[MjBody, ...]
    meshes: dict[str, MjMesh]


def read_mjcf(path: Path, root: Path) -> MjModel:
    """The model in a file. Nothing outside `root` is opened. Raises InvalidInput."""
    return model_of(parse_mjcf(path, root), path.name)


def model_of(top: Any, file: str) -> MjModel:
    """The model of a `<mujoco>` element; `file` is what findings name. Raises InvalidInput."""
    return _Reading(top, file).model()


class _Reading:
    """One pass over one parsed file."""

    def __init__(self, top: Any, file: str) -> None:
        compiler = {k: v for element in top.findall("compiler") for k, v in element.attrib.items()}
        if compiler.get("coordinate", "local") != "local":
            raise invalid_recording("replay/unsupported-model", "coordinate='global' is not read", file)
        self.file, self.top = file, top
        self.degrees = compiler.get("angle", "degree") == "degree"
        self.orientations = Orientations(self.degrees, compiler.get("eulerseq", "xyz"), file)
        self.mesh_folder = compiler.get("meshdir", compiler.get("assetdir", ""))
        self.defaults = defaults_of(top, file)
        self.bodies = [MjBody("world", -1, np.eye(4))]

    def model(self) -> MjModel:
        for world in self.top.findall("worldbody"):
            self._children(world, 0, np.eye(4), "")
        numbers_of = itertools.count()
        for body in self.bodies:
            body.geoms = [replace(geom, number=next(numbers_of)) for geom in body.geoms]
        meshes = {}
        for element in self.top.iterfind("asset/mesh"):
            a = self._attributes(element, "")
            file = a.get("file", "")
            name = a.get("name") or Path(file.replace("\\", "/")).stem
            if a.get("refpos") or a.get("refquat") or (not file and a.get("vertex")):
                raise invalid_recording(
                    "replay/unsupported-model", f"mesh '{name}': only files without refpos are read", self.file
                )
            meshes[name] = MjMesh(file, self.mesh_folder, numbers(a, "scale", 3, (1.0, 1.0, 1.0), self.file))
        return MjModel(self.file, tuple(self.bodies), meshes)

    def _children(self, element: Any, number: int, X_BF: FloatArray, inherited: str) -> None:
        """Read the children of a body, or of a frame at X_BF (4, 4) in it."""
        body = self.bodies[number]
        for child in element:
            if child.tag in _NOT_READ:
                message = f"<{child.tag}> is not read; save the model from MuJoCo in full (mj_saveLastXML)"
                raise invalid_recording("replay/unsupported-model", message, self.file, child.sourceline)
            if child.tag == "body":
                self._body(child, number, X_BF, inherited)
            elif child.tag == "frame":
                a = dict(child.attrib)
                self._children(child, number, X_BF @ self.orientations.pose(a), a.get("childclass", inherited))
            elif child.tag in ("joint", "freejoint"):
                body.joints.append(self._joint(child, self._attributes(child, inherited), body, X_BF))
            elif child.tag == "geom":
                body.geoms.append(self._geom(child, self._attributes(child, inherited), body, X_BF))
            elif child.tag == "camera":
                self._camera(self._attributes(child, inherited), body, X_BF)

    def _body(self, element: Any, parent: int, X_BF: FloatArray, inherited: str) -> None:
        a = dict(element.attrib)
        number = len(self.bodies)
        name = a.get("name") or f"body_{number}"
        self.bodies.append(MjBody(name, parent, X_BF @ self.orientations.pose(a)))
        self._children(element, number, np.eye(4), a.get("childclass", inherited))
        if a.get("mocap") == "true" and any(g.collides for g in self.bodies[number].geoms):
            message = f"body '{name}' is moved from outside (mocap); its motion is not in the states"
            raise invalid_recording("replay/unsupported-model", message, self.file, element.sourceline)

    def _attributes(self, element: Any, inherited: str) -> Attributes:
        """Attributes of an element over those of its class."""
        name = element.get("class", inherited) or "main"
        if name not in self.defaults:
            raise invalid_recording("replay/invalid-value", f"unknown class '{name}'", self.file, element.sourceline)
        tag = "joint" if element.tag == "freejoint" else element.tag
        of_class = self.defaults[name].get(tag, {}) if element.tag != "freejoint" else {}
        return {**of_class, **element.attrib}

    def _joint(self, element: Any, a: Attributes, body: MjBody, X_BF: FloatArray) -> MjJoint:
        kind = "free" if element.tag == "freejoint" else a.get("type", "hinge")
        name = a.get("name") or f"{body.name}_joint{len(body.joints)}"
        if kind not in ("hinge", "slide", "free"):
            message = f"joint '{name}' is of type '{kind}': only hinge, slide and free are read"
            raise invalid_recording("replay/unsupported-model", message, self.file, element.sourceline)
        axis = X_BF[:3, :3] @ np.array(numbers(a, "axis", 3, (0.0, 0.0, 1.0), self.file))
        if not np.linalg.norm(axis) > 1e-12:
            raise invalid_recording(
                "replay/invalid-value", f"joint '{name}' has no axis", self.file, element.sourceline
            )
        anchor = X_BF[:3, :3] @ np.array(numbers(a, "pos", 3, (0.0,) * 3, self.file)) + X_BF[:3, 3]
        reference = numbers(a, "ref", 1, (0.0,), self.file)[0]
        reference = float(np.radians(reference)) if kind == "hinge" and self.degrees else reference
        return MjJoint(name, kind, axis / np.linalg.norm(axis), anchor, reference)

    def _geom(self, element: Any, a: Attributes, body: MjBody, X_BF: FloatArray) -> MjGeom:
        kind = a.get("type", "mesh" if a.get("mesh") else "sphere")
        collides = numbers(a, "contype", 1, (1.0,), self.file)[0] != 0.0
        collides |= numbers(a, "conaffinity", 1, (1.0,), self.file)[0] != 0.0
        name = a.get("name", "")
        if kind not in _GEOMS or (a.get("mesh") and kind != "mesh"):
            if collides:
                message = f"geom '{name}' of body '{body.name}' is a '{kind}' that is not read"
                raise invalid_recording("replay/unsupported-model", message, self.file, element.sourceline)
            kind = "none"
        size = numbers(a, "size", len(a.get("size", "").split()), (), self.file)
        X_FG = self.orientations.pose(a)
        if a.get("fromto"):
            ends = np.array(numbers(a, "fromto", 6, None, self.file)).reshape(2, 3)
            X_FG = pose(self.orientations.z_along(ends[1] - ends[0]), ends.mean(axis=0))
            if not size:
                raise invalid_recording(
                    "replay/invalid-value", f"geom '{name}' has no size", self.file, element.sourceline
                )
            half = float(np.linalg.norm(ends[1] - ends[0])) / 2.0
            size = (size[0], half) if kind in ("capsule", "cylinder") else (size[0], size[0], half)
        return MjGeom(name, kind, size, X_BF @ X_FG, a.get("mesh", ""), bool(collides))

    def _camera(self, a: Attributes, body: MjBody, X_BF: FloatArray) -> None:
        if a.get("mode", "fixed") != "fixed" or a.get("orthographic") == "true":
            return  # A camera that follows something is no recorded camera.
        fovy = float(
            np.radians(numbers(a, "fovy", 1, (45.0,), self.file)[0])
        )  # In degrees for every setting of the compiler.
        name = a.get("name") or f"{body.name}_camera{len(body.cameras)}"
        body.cameras.append(MjCamera(name, X_BF @ self.orientations.pose(a), fovy))
