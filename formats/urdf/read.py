"""Reads a URDF file as a `RobotDescription`: every link and joint, SI, in the order of the file.

Format: wiki.ros.org/urdf/XML, with `<contact>` and `<capsule>` of PyBullet and `drake:proximity_properties`. Angles of
an origin are turns about fixed axes x, y, z. What has no place in the model is kept as text (`unread`).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from formats.attributes import choice, name_of, number, numbers, vector
from formats.findings import inertial_notes, link_notes, unread_notes
from formats.mesh_files import mesh_file
from formats.tree import check_mimics, root_of
from formats.xml_elements import Element, file_name, parse_file, refuse, synthetic
from geom.pose import pose, rotation_of_rpy
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.robot_description import (
    DescribedJoint,
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    DescribedShapeKind,
    Inertial,
    JointKind,
    JointLimits,
    MeshReference,
    Mimic,
    RobotDescription,
    ShapeFriction,
    UnreadElement,
)

DRAKE_PREFIX = "drake:"
PROXIMITY = DRAKE_PREFIX + "proximity_properties"
_KINDS: dict[str, JointKind] = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "floating": "floating",
    "planar": "planar",
    "spherical": "ball",
}
_UNIT_TOLERANCE = 0.01  # of the length of an axis: files round to two or three digits
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
_NONE = (0.0, 0.0, 0.0)
_NO_ELEMENT = synthetic("none", {})


def read_urdf(path: Path, root: Path | None = None) -> RobotDescription:
    """The description in a file. `root` (default: the file's folder) is the folder that no reference leaves.

    Raises InvalidInput with a `robot/` code, file and line.
    """
    root = path.parent if root is None else root
    return _Reading(parse_file(path, root), path.parent, root, file_name(path, root)).description()


class _Reading:
    """One pass over one parsed file."""

    def __init__(self, top: Element, folder: Path, root: Path, file: str) -> None:
        self.top, self.folder, self.root, self.file = top, folder, root, file
        self.unread: list[UnreadElement] = []
        self.notes: list[Diagnostic] = []
        self.materials: dict[str, DescribedMaterial] = {}

    def description(self) -> RobotDescription:
        top = self.top
        if top.tag != "robot":
            refuse("robot/unknown-root", f"the outermost element is <{top.tag}>, not <robot>", top.source, top.tag)
        self._refuse_templates()
        for element in top.named("material"):
            self._material(element)
        links = tuple(self._link(element) for element in top.named("link"))
        joints = tuple(self._joint(element) for element in top.named("joint"))
        root = root_of(links, joints, top.source)
        check_mimics(joints)
        self._keep_unread(top, "robot", ("link", "joint", "material"))
        notes = (*self.notes, *link_notes(links), *unread_notes(self.unread))
        return RobotDescription(
            top.get("name"), "urdf", links, joints, root, tuple(self.unread), notes, source=top.source
        )

    def _refuse_templates(self) -> None:
        for element in self.top.walk():
            if element.tag.startswith("xacro:") or any(
                "${" in value or "$(" in value for value in element.attributes.values()
            ):
                refuse("robot/xacro", f"<{element.tag}> is part of a xacro template", element.source, element.tag)

    def _keep_unread(self, element: Element, inside: str, read: tuple[str, ...]) -> None:
        for child in element.children:
            if child.tag not in read:
                self.unread.append(UnreadElement(child.tag, child.text, inside, child.source))

    def _link(self, element: Element) -> DescribedLink:
        name = name_of(element)
        inertial = self._inertial(element, name)
        shapes = [self._shape(child, name) for child in element.children if child.tag in ("visual", "collision")]
        self._keep_unread(element, name, ("inertial", "visual", "collision", "contact"))
        return DescribedLink(
            name,
            tuple(shape for shape in shapes if shape is not None),
            inertial,
            "missing" if inertial is None else "declared",
            self._contact(element, name),
            source=element.source,
        )

    def _contact(self, link: Element, name: str) -> Mapping[str, float]:
        contact: dict[str, float] = {}
        for element in link.named("contact"):
            for child in element.children:
                if "value" in child.attributes:
                    contact[child.tag] = number(child.attributes, "value", None, child.source)
                else:
                    self.unread.append(UnreadElement(child.tag, child.text, name, child.source))
        return contact

    def _inertial(self, link: Element, name: str) -> Inertial | None:
        element = link.first("inertial")
        if element is None:
            return None
        mass, entries = element.first("mass"), element.first("inertia")
        if mass is None:
            self._note("robot/invalid-mass", f"<inertial> of link '{name}' has no <mass>", element)
        tensor = None
        if entries is not None:
            xx, yy, zz, xy, xz, yz = (
                number(entries.attributes, f"i{n}", 0.0, entries.source) for n in ("xx", "yy", "zz", "xy", "xz", "yz")
            )
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        mass_kg = number(mass.attributes, "value", 0.0, mass.source) if mass is not None else 0.0
        inertial = Inertial(mass_kg, _origin(element), tensor, element.source)
        self.notes += inertial_notes(name, inertial)
        return inertial

    def _shape(self, element: Element, link: str) -> DescribedShape | None:
        """A `<visual>` or `<collision>`; None where it has no geometry."""
        drawn, place = element.tag == "visual", f"{element.tag} of link '{link}'"
        geometry = element.first("geometry")
        kind = geometry.children[0] if geometry is not None and geometry.children else None
        self._keep_unread(element, link, ("origin", "geometry", "material", PROXIMITY))
        if kind is None:
            self._note("robot/unsupported-shape", f"{place} has no geometry", element, Severity.WARNING)
            return None
        shape_kind, size_m, problem = _geometry(kind, place)
        material = next((self._material(child) for child in element.named("material")), None)
        if problem is not None:
            self.notes.append(problem)
        return DescribedShape(
            name=element.get("name"),
            kind=shape_kind,
            size_m=size_m,
            X_LS=_origin(element),
            collides=not drawn,
            drawn=drawn,
            mesh=self._mesh(kind) if shape_kind == "mesh" else None,
            material=material,
            friction=_friction(element.first(PROXIMITY)),
            problem=problem,
            source=element.source,
        )

    def _mesh(self, element: Element) -> MeshReference:
        uri, scale = element.get("filename"), vector(element.attributes, "scale", (1.0, 1.0, 1.0), element.source)
        if not uri:
            refuse("robot/missing-name", "a <mesh> has no filename", element.source)
        path, problem = mesh_file(uri, self.folder, self.root, element.source)
        if problem is not None:
            self.notes.append(problem)
        return MeshReference(uri, path, scale, problem=problem, source=element.source)

    def _material(self, element: Element) -> DescribedMaterial:
        """A material, or the one of the whole robot that has its name. Each named one is kept for the references."""
        color, texture, name = element.first("color"), element.first("texture"), element.get("name")
        if color is None and texture is None:
            if name and name not in self.materials:
                headline = f"material '{name}' is defined nowhere above"
                self._note("robot/unknown-reference", headline, element, Severity.WARNING)
            return self.materials.get(name, DescribedMaterial(name, source=element.source))
        rgba = None
        if color is not None:
            red, green, blue, opacity = numbers(color.attributes, "rgba", 4, (1.0,) * 4, color.source)
            rgba = (red, green, blue, opacity)
        file = texture.get("filename") if texture is not None else ""
        material = DescribedMaterial(name, rgba, file, element.source)
        if name:
            self.materials.setdefault(name, material)
        return material

    def _axis(self, joint: Element, kind: JointKind, name: str) -> FloatArray:
        """Unit vector; some files have an axis of zeros where it means nothing."""
        if kind not in _WITH_AXIS:
            return np.array([0.0, 0.0, 1.0])
        element = joint.first("axis")
        axis = np.array(vector(element.attributes, "xyz", None, element.source) if element else (1.0, 0.0, 0.0))
        length, source = float(np.linalg.norm(axis)), (element or joint).source
        if not length > 1e-12:
            refuse("robot/zero-axis", f"joint '{name}' has an axis of zeros", source, 0.0)
        if abs(length - 1.0) > _UNIT_TOLERANCE:
            headline = f"joint '{name}' has an axis of length {length:.6g}; its direction counts"
            where = source.location
            self.notes.append(finding("robot/axis-not-unit", headline, where=where, value=length, bound=1.0))
        return axis / length

    def _joint(self, element: Element) -> DescribedJoint:
        name, source = name_of(element), element.source
        kind = _KINDS[choice(element.attributes, "type", tuple(_KINDS), "", source)]
        dynamics, limit = element.first("dynamics") or _NO_ELEMENT, element.first("limit") or _NO_ELEMENT
        self._keep_unread(element, name, ("origin", "parent", "child", "axis", "dynamics", "limit", "mimic"))
        return DescribedJoint(
            name=name,
            kind=kind,
            parent=_end(element, "parent", name),
            child=_end(element, "child", name),
            X_PC=_origin(element),
            axis_C=self._axis(element, kind, name),
            limits=self._limits(limit, kind, name, element),
            effort=_optional(limit, "effort"),
            velocity=_optional(limit, "velocity"),
            damping=number(dynamics.attributes, "damping", 0.0, dynamics.source),
            friction=number(dynamics.attributes, "friction", 0.0, dynamics.source),
            mimic=_mimic(element.first("mimic")),
            source=source,
        )

    def _limits(self, limit: Element, kind: JointKind, name: str, joint: Element) -> JointLimits | None:
        if kind not in ("revolute", "prismatic"):
            return None
        if not {"lower", "upper"} & limit.attributes.keys():
            self._note("robot/missing-limit", f"joint '{name}' is {kind} and states no limits", joint)
            return None
        lower, upper = (number(limit.attributes, key, 0.0, limit.source) for key in ("lower", "upper"))
        if lower >= upper:
            headline = f"joint '{name}' has lower limit {lower:g} and upper limit {upper:g}"
            self.notes.append(
                finding("robot/reversed-limits", headline, where=limit.source.location, value=lower, bound=upper)
            )
        return JointLimits(lower, upper)

    def _note(self, code: str, headline: str, element: Element, severity: Severity | None = None) -> None:
        self.notes.append(finding(code, headline, where=element.source.location, severity=severity))


def _geometry(element: Element, place: str) -> tuple[DescribedShapeKind, tuple[float, ...], Diagnostic | None]:
    """Kind and sizes of the element inside `<geometry>`, and why it is no shape."""
    a, source = element.attributes, element.source
    try:
        if element.tag == "box":
            return "box", _positive(numbers(a, "size", 3, None, source), element, place), None
        if element.tag == "sphere":
            return "sphere", _positive(numbers(a, "radius", 1, None, source), element, place), None
        if element.tag in ("cylinder", "capsule"):
            size = (number(a, "radius", None, source), number(a, "length", None, source))
            kind: DescribedShapeKind = "cylinder" if element.tag == "cylinder" else "capsule"
            return kind, _positive(size, element, place), None
    except InvalidInput as refused:
        return "unknown", (), refused.diagnostic
    if element.tag == "mesh":
        return "mesh", (), None
    headline = f"<{element.tag}> of {place} is not read"
    problem = finding("robot/unsupported-shape", headline, where=source.location, value=element.tag)
    return "unknown", (), problem


def _positive(size: tuple[float, ...], element: Element, place: str) -> tuple[float, ...]:
    if min(size) <= 0.0:
        refuse("robot/invalid-size", f"<{element.tag}> of {place} has size {size}", element.source, min(size), 0.0)
    return size


def _friction(element: Element | None) -> ShapeFriction | None:
    """Drake's coefficients; None where one of them is not stated."""
    static, dynamic = (element.first(DRAKE_PREFIX + n) if element else None for n in ("mu_static", "mu_dynamic"))
    if static is None or dynamic is None:
        return None
    return ShapeFriction(*(number(e.attributes, "value", None, e.source) for e in (static, dynamic)))


def _origin(element: Element) -> FloatArray:
    """X (4, 4) of its `<origin>`."""
    origin = element.first("origin") or _NO_ELEMENT
    R = rotation_of_rpy(vector(origin.attributes, "rpy", _NONE, origin.source))
    return pose(R, np.array(vector(origin.attributes, "xyz", _NONE, origin.source)))


def _end(joint: Element, tag: str, name: str) -> str:
    element = joint.first(tag)
    link = element.get("link") if element is not None else ""
    if not link:
        refuse("robot/missing-link", f"joint '{name}' has no {tag} link", joint.source)
    return link


def _mimic(element: Element | None) -> Mimic | None:
    if element is None:
        return None
    if not element.get("joint"):
        refuse("robot/missing-name", "a <mimic> names no joint", element.source)
    multiplier, offset = (
        number(element.attributes, key, default, element.source)
        for key, default in (("multiplier", 1.0), ("offset", 0.0))
    )
    return Mimic(element.get("joint"), multiplier, offset)


def _optional(element: Element, name: str) -> float | None:
    return number(element.attributes, name, None, element.source) if name in element.attributes else None
