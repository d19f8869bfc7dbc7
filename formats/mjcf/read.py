"""Reads a MuJoCo model file as a `RobotDescription` (m, rad), bodies depth first as MuJoCo numbers them.

Format: mujoco.readthedocs.io/en/stable/XMLreference.html. The world is the first link and the root; a body without
joints is welded to its parent by a fixed joint that the file does not state. Read are trees of bodies with defaults,
frames and includes, mesh assets, materials, and equalities that tie one joint to another; the rest is kept as text.
Frames: B body, F frame or body around an element, G geom, C camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from formats.attributes import choice, flag, number, numbers, vector
from formats.findings import inertial_notes, link_notes, unread_notes
from formats.mjcf.assets import Assets
from formats.mjcf.defaults import Defaults
from formats.mjcf.equalities import with_mimics
from formats.mjcf.geoms import geom_shape
from formats.mjcf.includes import with_includes
from formats.mjcf.settings import compiler_settings
from formats.tree import root_of
from formats.xml_elements import Element, file_name, parse_bytes, parse_file, refuse
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.robot_description import (
    WORLD_LINK,
    DescribedCamera,
    DescribedJoint,
    DescribedLink,
    DescribedShape,
    Inertial,
    InertiaSource,
    JointKind,
    JointLimits,
    RobotDescription,
    SourceLine,
    UnreadElement,
)

MAKES_BODIES = ("composite", "flexcomp", "replicate", "attach", "plugin")  # read by MuJoCo alone
_JOINTS: dict[str, JointKind] = {"hinge": "revolute", "slide": "prismatic", "ball": "ball", "free": "floating"}
_SECTIONS = ("compiler", "default", "worldbody", "asset", "equality")


def read_mjcf(path: Path, root: Path | None = None) -> RobotDescription:
    """The description in a file. `root` (default: the file's folder) is the folder that no reference leaves.

    Raises InvalidInput with a `robot/` code, file and line.
    """
    root = path.parent if root is None else root
    return _read(parse_file(path, root), path.parent, root, file_name(path, root))


def parse_mjcf(text: bytes, file: str, folder: Path) -> RobotDescription:
    """The same of a model given as text; it may include files of `folder`. `file` is what findings name."""
    return _read(parse_bytes(text, file), folder, folder, file)


def _read(top: Element, folder: Path, root: Path, file: str) -> RobotDescription:
    if top.tag != "mujoco":
        refuse(
            "robot/unknown-root", f"the outermost element is <{top.tag}>, not <mujoco>", SourceLine(file, 1), top.tag
        )
    return _Reading(with_includes(top, folder, root), folder, root).description()


@dataclass
class _Body:
    """A body while its children are read."""

    name: str
    parent: str
    X_PB: FloatArray
    source: SourceLine
    mocap: bool = False
    joints: list[DescribedJoint] = field(default_factory=list[DescribedJoint])
    shapes: list[DescribedShape] = field(default_factory=list[DescribedShape])
    cameras: list[DescribedCamera] = field(default_factory=list[DescribedCamera])
    inertial: Inertial | None = None


@dataclass
class _Level:
    """Children still to be read of a body or of a frame at X_BF in it; `inherited` is the class of defaults."""

    children: Iterator[Element]
    body: _Body
    X_BF: FloatArray
    inherited: str


class _Reading:
    """One pass over one model whose includes are in place."""

    def __init__(self, top: Element, folder: Path, root: Path) -> None:
        self.top = top
        self.settings = compiler_settings(top)
        self.orientations = self.settings.orientations
        self.defaults = Defaults(top)
        self.unread: list[UnreadElement] = []
        self.notes: list[Diagnostic] = []
        self.assets = Assets(top, self.defaults, self.settings, folder, root)
        self.bodies = [_Body(WORLD_LINK, "", np.eye(4), top.source)]

    def description(self) -> RobotDescription:
        for world in self.top.named("worldbody"):
            self._tree(world)
        for child in self.top.children:
            if child.tag not in _SECTIONS:
                self._keep(child, "mujoco")
        joints = tuple(joint for body in self.bodies[1:] for joint in body.joints or [_weld(body)])
        equalities = [child for section in self.top.named("equality") for child in section.children]
        joints, unread_equalities = with_mimics(joints, equalities, self.defaults)
        for child in unread_equalities:
            self._keep(child, "equality")
        for child in self.assets.unread:
            self._keep(child, "asset")
        links = tuple(self._link(body) for body in self.bodies)
        root_of(links, joints, self.top.source)
        notes = (*self.notes, *self.assets.notes, *link_notes(links), *unread_notes(self.unread))
        return RobotDescription(
            self.top.get("model"),
            "mjcf",
            links,
            joints,
            WORLD_LINK,
            tuple(self.unread),
            notes,
            self.settings.stated,
            self.top.source,
        )

    def _keep(self, element: Element, inside: str) -> None:
        makes_bodies = element.tag in MAKES_BODIES and inside != "mujoco"
        self.unread.append(UnreadElement(element.tag, element.text, inside, element.source, makes_bodies))

    def _tree(self, world: Element) -> None:
        """All bodies below `world`, depth first and without recursion: chains may have thousands of links."""
        levels = [_Level(iter(world.children), self.bodies[0], np.eye(4), world.get("childclass"))]
        while levels:
            level = levels[-1]
            child = next(level.children, None)
            if child is None:
                levels.pop()
            elif child.tag == "body":
                body = self._body(child, level)
                levels.append(_Level(iter(child.children), body, np.eye(4), child.get("childclass", level.inherited)))
            elif child.tag == "frame":
                X_BF = level.X_BF @ self.orientations.pose(child.attributes, child.source)
                inherited = child.get("childclass", level.inherited)
                levels.append(_Level(iter(child.children), level.body, X_BF, inherited))
            else:
                self._part(child, level)

    def _body(self, element: Element, level: _Level) -> _Body:
        name = element.get("name") or f"body_{len(self.bodies)}"
        X_PB = level.X_BF @ self.orientations.pose(element.attributes, element.source)
        mocap = flag(element.attributes, "mocap", False, element.source)
        self.bodies.append(_Body(name, level.body.name, X_PB, element.source, mocap))
        return self.bodies[-1]

    def _part(self, element: Element, level: _Level) -> None:
        """A child of a body or a frame that is no body or frame."""
        body, X_BF = level.body, level.X_BF
        if element.tag in ("joint", "freejoint"):
            if body is self.bodies[0]:
                refuse("robot/invalid-value", "the world has a joint", element.source)
            body.joints.append(self._joint(element, level))
        elif element.tag == "geom":
            a = self.defaults.attributes(element, level.inherited)
            shape = geom_shape(a, element.source, body.name, X_BF, self.settings, self.assets)
            self.notes += [] if shape.problem is None else [shape.problem]
            body.shapes.append(shape)
        elif element.tag == "inertial":
            body.inertial = self._inertial(element, body)
        elif element.tag == "camera":
            body.cameras.append(self._camera(element, level))
        else:
            self._keep(element, body.name)

    def _joint(self, element: Element, level: _Level) -> DescribedJoint:
        a, body, source = self.defaults.attributes(element, level.inherited), level.body, element.source
        free = element.tag == "freejoint"
        kind = "floating" if free else _JOINTS[choice(a, "type", tuple(_JOINTS), "hinge", source)]
        name = a.get("name") or f"{body.name}_joint{len(body.joints)}"
        if kind == "floating":
            return DescribedJoint(name, kind, body.parent, body.name, body.X_PB, source=source)
        R_BF = level.X_BF[:3, :3]
        axis_B = R_BF @ np.array(vector(a, "axis", (0.0, 0.0, 1.0), source))
        length = float(np.linalg.norm(axis_B))
        if kind != "ball" and not length > 1e-12:
            refuse("robot/zero-axis", f"joint '{name}' has an axis of zeros", source, value=0.0)
        rad_per_unit = self.orientations.rad_per_unit if kind == "revolute" else 1.0
        reference, spring = (
            number(a, key, 0.0, source) if kind == "prismatic" else float(number(a, key, 0.0, source) * rad_per_unit)
            for key in ("ref", "springref")
        )
        limits = self._limits(a, kind, name, source)
        return DescribedJoint(
            name=name,
            kind="continuous" if kind == "revolute" and limits is None else kind,
            parent=body.parent,
            child=body.name,
            X_PC=body.X_PB,
            axis_C=axis_B / length if kind != "ball" else np.array([0.0, 0.0, 1.0]),
            anchor_C=R_BF @ np.array(vector(a, "pos", (0.0, 0.0, 0.0), source)) + level.X_BF[:3, 3],
            reference=reference,
            limits=limits,
            effort=self._effort(a, source),
            damping=self._linear(a, "damping", source),
            friction=number(a, "frictionloss", 0.0, source),
            armature=number(a, "armature", 0.0, source),
            stiffness=self._linear(a, "stiffness", source),
            spring_reference=spring,
            source=source,
        )

    def _limits(self, a: dict[str, str], kind: JointKind, name: str, source: SourceLine) -> JointLimits | None:
        """Limits where the joint has some: MuJoCo infers it from a range that goes up."""
        limited = choice(a, "limited", ("true", "false", "auto"), "auto", source)
        if limited == "false" or (limited == "auto" and "range" not in a):
            return None
        if limited == "auto" and not self.settings.infer_limits:
            headline = f"joint '{name}' has a range but not limited=, which autolimits='false' asks for"
            refuse("robot/invalid-value", headline, source, value=a["range"])
        rad_per_unit = self.orientations.rad_per_unit if kind != "prismatic" else 1.0
        lower, upper = (float(v * rad_per_unit) for v in numbers(a, "range", 2, (0.0, 0.0), source))
        if lower >= upper:
            headline = f"joint '{name}' has lower limit {lower:g} and upper limit {upper:g}"
            self.notes.append(
                finding("robot/reversed-limits", headline, where=source.location, value=lower, bound=upper)
            )
        return JointLimits(lower, upper)

    def _effort(self, a: dict[str, str], source: SourceLine) -> float | None:
        """The largest effort of all actuators together, where it is the same in both directions."""
        if "actuatorfrcrange" not in a or a.get("actuatorfrclimited") == "false":
            return None
        least, most = numbers(a, "actuatorfrcrange", 2, None, source)
        return most if least == -most and most > 0.0 else None

    def _linear(self, a: dict[str, str], name: str, source: SourceLine) -> float:
        """The first coefficient of damping or stiffness; MuJoCo 4 may have a polynomial, which is kept as text."""
        values = numbers(a, name, None, (0.0,), source)
        if any(values[1:]):
            self.unread.append(UnreadElement(name, a[name], "joint", source))
        return values[0] if values else 0.0

    def _inertial(self, element: Element, body: _Body) -> Inertial:
        a, source = element.attributes, element.source
        if "pos" not in a:
            headline = f"<inertial> of body '{body.name}' has no pos, which MuJoCo asks for; taken as 0 0 0"
            self.notes.append(finding("robot/missing-attribute", headline, where=source.location))
        if "fullinertia" in a:
            xx, yy, zz, xy, xz, yz = numbers(a, "fullinertia", 6, None, source)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            tensor = np.diag(vector(a, "diaginertia", None, source)) if "diaginertia" in a else None
        inertial = Inertial(number(a, "mass", None, source), self.orientations.pose(a, source), tensor, source)
        self.notes += inertial_notes(body.name, inertial)
        return inertial

    def _camera(self, element: Element, level: _Level) -> DescribedCamera:
        a, body, source = self.defaults.attributes(element, level.inherited), level.body, element.source
        fixed = a.get("mode", "fixed") == "fixed" and a.get("orthographic") != "true"
        fovy_rad = float(np.radians(number(a, "fovy", 45.0, source)))  # In degrees for every setting of the compiler.
        name = a.get("name") or f"{body.name}_camera{len(body.cameras)}"
        return DescribedCamera(name, level.X_BF @ self.orientations.pose(a, source), fovy_rad, fixed, source)

    def _link(self, body: _Body) -> DescribedLink:
        rule = self.settings.inertia_from_geoms
        weighs = any(shape.mass_kg is not None or shape.density_kgm3 is not None for shape in body.shapes)
        from_shapes = rule == "true" or (rule == "auto" and body.inertial is None)
        inertia_source: InertiaSource = "missing"
        if body is not self.bodies[0]:
            inertia_source = "shapes" if from_shapes and weighs else "declared" if body.inertial else "missing"
        return DescribedLink(
            body.name,
            tuple(body.shapes),
            body.inertial,
            inertia_source,
            cameras=tuple(body.cameras),
            mocap=body.mocap,
            source=body.source,
        )


def _weld(body: _Body) -> DescribedJoint:
    """The fixed joint of a body that has none."""
    return DescribedJoint(
        f"{body.name}_weld", "fixed", body.parent, body.name, body.X_PB, stated=False, source=body.source
    )
