"""The links of a recorded robot (m, rad) from its URDF: every link is kept, mimic joints follow what they mimic."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from formats.tree import breadth_first
from geom.pose import apply
from replay.recording.episode import JointKind, Link
from replay.recording.recorded_numbers import invalid_recording
from replay.recording.robot_files import as_recording_finding, recorded_urdf
from replay.recording.shapes import described_mesh, hull
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape
from schemas.robot_description import DescribedJoint, DescribedLink, DescribedShape, RobotDescription

_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}


@dataclass(frozen=True)
class RobotLinks:
    """Links, parents first, and the names of the coordinates that drive them, in the order of the file."""

    links: tuple[Link, ...]
    coordinates: tuple[str, ...]


def read_robot_links(
    path: Path, root: Path, meshes: Path | None = None, measured: Callable[[str], bool] = lambda joint: False
) -> RobotLinks:
    """The robot of a file; its meshes from below `root`, else from `meshes`.

    A mimic joint that was recorded itself (`measured`) follows its record: many engines and grippers do not keep the
    fingers as equal as the file states. Raises InvalidInput.
    """
    description = recorded_urdf(path, root)
    joints = {joint.name: joint for joint in description.joints}
    for joint in joints.values():
        if joint.kind not in _KINDS:
            message = f"joint '{joint.name}' is of type '{joint.kind}': not read"
            raise invalid_recording("replay/unsupported-model", message, joint.source.file, joint.source.line)
    driven = [j.name for j in joints.values() if j.moves and (j.mimic is None or measured(j.name))]
    return RobotLinks(_links(description, joints, driven, _Meshes(path.name, root, meshes)), tuple(driven))


def _links(
    description: RobotDescription, joints: Mapping[str, DescribedJoint], driven: list[str], meshes: _Meshes
) -> tuple[Link, ...]:
    """Every link after its parent; visuals are the shapes of a link that moves and has no others."""
    order = breadth_first(description)
    number_of = {name: number for number, name in enumerate(order)}
    described = {link.name: link for link in description.links}
    carrier = {joint.child: joint for joint in joints.values()}
    base = DescribedJoint("", "fixed", "", description.root)
    links: list[Link] = []
    moves: set[str] = set()
    for name in order:
        joint = carrier.get(name, base)
        if joint.moves or joint.parent in moves:
            moves.add(name)
        coordinate, gain, offset = _drive(joint, joints, driven) if joint.moves else (-1, 1.0, 0.0)
        shapes = tuple(meshes.shape(shape, name) for shape in _shapes_of(described[name], name in moves))
        links.append(
            Link(
                name,
                number_of.get(joint.parent, -1),
                _KINDS[joint.kind],
                joint.axis_C,
                joint.X_PC,
                coordinate,
                gain,
                offset,
                shapes,
            )
        )
    return tuple(links)


def _drive(joint: DescribedJoint, joints: Mapping[str, DescribedJoint], driven: list[str]) -> tuple[int, float, float]:
    """Coordinate, gain and offset of a movable joint, through joints that it mimics."""
    gain, offset, at = 1.0, 0.0, joint
    while at.name not in driven and at.mimic is not None:
        offset += gain * at.mimic.offset
        gain *= at.mimic.multiplier
        at = joints[at.mimic.joint]
    if at.name not in driven:
        message = f"a mimic joint follows '{at.name}', which drives nothing"
        raise invalid_recording("replay/invalid-value", message, joint.source.file, joint.source.line)
    return driven.index(at.name), gain, offset


def _shapes_of(link: DescribedLink, moves: bool) -> list[DescribedShape]:
    colliding = [shape for shape in link.shapes if shape.collides]
    return colliding or ([shape for shape in link.shapes if shape.drawn] if moves else [])


class _Meshes:
    """Shapes of a description called `file`, with mesh files from below `root` or else from `meshes`."""

    def __init__(self, file: str, root: Path, meshes: Path | None) -> None:
        self.file, self.root, self.meshes = file, root, meshes

    def shape(self, shape: DescribedShape, link: str) -> CollisionShape:
        """One shape in the frame of its link. Raises InvalidInput for a shape that cannot be used."""
        if shape.problem is not None:
            raise InvalidInput(as_recording_finding(shape.problem))
        if shape.mesh is None:
            return CollisionShape(shape.kind, shape.size_m, shape.X_LS)  # pyright: ignore[reportArgumentType]
        vertices = described_mesh(shape.mesh, self.root, self.meshes, self.file)
        return hull(apply(shape.X_LS, vertices), link, self.file)
