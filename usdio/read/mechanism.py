"""Links and joints of a foreign stage (UsdPhysics) as a description: a tree of rigid bodies, and the joints beside it.

Input is the composed stage, posed as authored; output is in the frame and the units of length of the stage, radians,
kilograms and newtons. What no rigid body holds is the link `world`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from formats.mechanism import MechanismReading, read_mechanism
from formats.tree import check_mimics
from geom.pose import inverse, matrix_of, pose
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.identifiers import unique_identifiers
from schemas.model import Mesh
from schemas.robot_description import (
    WORLD_LINK,
    DescribedJoint,
    DescribedLink,
    JointKind,
    JointLimits,
    Mimic,
    RobotDescription,
    SourceLine,
)
from usdio.joint_frames import AXES, joint_position
from usdio.joint_names import LEADER, MULTIPLIER, OFFSET
from usdio.read.gprim_placement import column_matrix
from usdio.read.meshes import EARLIEST

_KINDS: Mapping[str, JointKind] = {
    "PhysicsFixedJoint": "fixed",
    "PhysicsRevoluteJoint": "revolute",
    "PhysicsPrismaticJoint": "prismatic",
    "PhysicsSphericalJoint": "ball",
}
_LEAST_QUATERNION = 1e-6  # shorter ones have no direction


@dataclass(frozen=True)
class StageMechanism:
    """What moves in a stage, with findings, and the link of each of its meshes by `Mesh.source_path`."""

    reading: MechanismReading
    link_of: Mapping[str, str]


def stage_mechanism(stage: Usd.Stage, meshes: Sequence[Mesh], where: Location) -> StageMechanism | None:
    """None for a stage without joints between bodies.

    Raises InvalidInput as `read_mechanism` does, `robot/not-expressible` for joints of other kinds,
    `robot/several-roots` for bodies with meshes that no joint connects with the others, `robot/zero-axis`, and for
    couplings as `check_mimics` does.
    """
    return _StageReader(stage, meshes, where).read()


@dataclass
class _Edge:
    """A joint with its two links, and its frame in the world by either side."""

    prim: Usd.Prim
    first: str
    second: str
    X_W0: FloatArray
    X_W1: FloatArray


class _StageReader:
    """One pass over the bodies and joints of a stage."""

    def __init__(self, stage: Usd.Stage, meshes: Sequence[Mesh], where: Location) -> None:
        prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
        bodies = [p for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI) and _enabled(p)]
        names = unique_identifiers([WORLD_LINK, *(p.GetName() for p in bodies)], "link")
        self.stage, self.meshes, self.where = stage, meshes, where
        self.name_of = {str(p.GetPath()): n for p, n in zip(bodies, list(names)[1:], strict=True)}
        self.prim_of = {n: p for p, n in zip(bodies, list(names)[1:], strict=True)}
        self.joints = [p for p in prims if p.IsA(UsdPhysics.Joint) and _flag(p, "physics:jointEnabled", True)]
        unique = unique_identifiers([p.GetName() for p in self.joints], "joint")
        self.joint_name = {str(p.GetPath()): n for p, n in zip(self.joints, unique, strict=True)}
        self.roots = [p for p in prims if p.HasAPI(UsdPhysics.ArticulationRootAPI)]
        self.source = SourceLine(where.file or "")
        self.cache = UsdGeom.XformCache(EARLIEST)
        self.notes: list[Diagnostic] = []

    def read(self) -> StageMechanism | None:
        edges = [edge for prim in self.joints if (edge := self._edge(prim)) is not None]
        if not any(WORLD_LINK not in (e.first, e.second) for e in edges) and not self._statics_are_linked(edges):
            return None
        link_of = {mesh.source_path: self._link_of(mesh.source_path) for mesh in self.meshes}
        if not any(WORLD_LINK in (e.first, e.second) for e in edges):
            link_of = self._without_surroundings(link_of)
        shaped = set(link_of.values())
        tree, loops = self._tree(edges)
        check_mimics([*tree, *loops])
        links = tuple(DescribedLink(name) for name in (WORLD_LINK, *self.prim_of))
        joined = {WORLD_LINK, *(j.child for j in tree)}
        joints = (*tree, *self._unjoined(links, joined, shaped))
        description = RobotDescription(
            self.stage.GetDefaultPrim().GetName() if self.stage.GetDefaultPrim() else "",
            "usd",
            links,
            joints,
            WORLD_LINK,
            source=self.source,
        )
        reading = read_mechanism(description, shaped, loops)
        reading = replace(reading, notes=(*self.notes, *reading.notes))
        placed = self._with_prims(reading)
        return StageMechanism(placed, {path: reading.link_of[name] for path, name in link_of.items()})

    def _without_surroundings(self, link_of: Mapping[str, str]) -> dict[str, str]:
        """The meshes that bodies hold; others are ground and walls where no joint leads to them."""
        held = {path: link for path, link in link_of.items() if link != WORLD_LINK}
        if left := sorted(link_of.keys() - held.keys()):
            headline = f"{len(left)} surfaces that no body holds and no joint leads to were left out"
            where = self.where.model_copy(update={"prim": left[0]})
            self.notes.append(finding("asset/geometry-left-out", headline, where=where, value=len(left)))
        return held

    def _statics_are_linked(self, edges: Sequence[_Edge]) -> bool:
        """Whether a joint moves a body against visible surface that no body holds, such as a static cabinet."""
        static = any(self._link_of(mesh.source_path) == WORLD_LINK for mesh in self.meshes)
        return static and any(edge.prim.GetTypeName() != "PhysicsFixedJoint" for edge in edges)

    def _link_of(self, path: str) -> str:
        """The link of a prim: that of its nearest ancestor, or itself, which is a body."""
        while path and path != "/":
            if path in self.name_of:
                return self.name_of[path]
            path = path.rpartition("/")[0]
        return WORLD_LINK

    def _edge(self, prim: Usd.Prim) -> _Edge | None:
        """The joint as an edge between links; None where both ends are one link or nothing is there."""
        joint = UsdPhysics.Joint(prim)
        targets = [rel.GetForwardedTargets() for rel in (joint.GetBody0Rel(), joint.GetBody1Rel())]
        ends = [self._link_of(str(t[0])) if t else WORLD_LINK for t in targets]
        if ends[0] == ends[1]:
            return None
        frames = [self._frame(prim, side, str(t[0]) if t else "") for side, t in enumerate(targets)]
        return _Edge(prim, ends[0], ends[1], frames[0], frames[1])

    def _frame(self, prim: Usd.Prim, side: int, target: str) -> FloatArray:
        """The joint's frame in the world by one side; the position is scaled with the prim, the rotation is not."""
        position = prim.GetAttribute(f"physics:localPos{side}").Get(EARLIEST)
        rotation = prim.GetAttribute(f"physics:localRot{side}").Get(EARLIEST)
        p = np.zeros(3) if position is None else np.array(position, dtype=np.float64)
        quat = np.array([1.0, 0.0, 0.0, 0.0])
        if rotation is not None:
            quat = np.array([rotation.GetReal(), *rotation.GetImaginary()], dtype=np.float64)
        if not (np.isfinite(p).all() and np.isfinite(quat).all()):
            self._refuse("robot/invalid-number", f"localPos{side} or localRot{side} is not finite", prim)
        if np.linalg.norm(quat) < _LEAST_QUATERNION:
            self._refuse("robot/zero-axis", f"localRot{side} has no direction", prim)
        at = self.stage.GetPrimAtPath(target) if target else None
        if at is None or not at:
            return pose(matrix_of(quat), p)
        X_WT = column_matrix(self.cache.GetLocalToWorldTransform(at))
        return pose(_rotation(X_WT) @ matrix_of(quat), X_WT[:3, :3] @ p + X_WT[:3, 3])

    def _tree(self, edges: Sequence[_Edge]) -> tuple[list[DescribedJoint], list[DescribedJoint]]:
        """Joints that carry links, from the base outwards, and those that close loops."""
        closing = [e for e in edges if _flag(e.prim, "physics:excludeFromArticulation", False)]
        open_edges = [e for e in edges if e not in closing]
        tree: list[DescribedJoint] = []
        reached: set[str] = set()
        for start in self._starts(open_edges):
            if start in reached:
                continue
            if start != WORLD_LINK and reached:
                break  # Other bodies are judged by `_unjoined`.
            reached.add(start)
            if start != WORLD_LINK:
                tree.append(self._base(start))
            order = [start]
            for link in order:  # Grows while it is walked.
                for edge in open_edges:
                    other = edge.second if edge.first == link else edge.first if edge.second == link else None
                    if other is not None and other not in reached:
                        reached.add(other)
                        order.append(other)
                        tree.append(self._described(edge, link, other))
        used = {joint.name for joint in tree}
        closing += [e for e in open_edges if self._name(e.prim) not in used and {e.first, e.second} <= reached]
        moving = [e for e in closing if e.prim.GetTypeName() != "PhysicsFixedJoint"]
        return tree, [self._described(edge, edge.first, edge.second) for edge in moving]

    def _starts(self, edges: Sequence[_Edge]) -> list[str]:
        """Where the tree may begin: the world if a joint leads there, else the body that is marked, or none's child."""
        if any(WORLD_LINK in (e.first, e.second) for e in edges):
            return [WORLD_LINK]
        marked = [n for n, p in self.prim_of.items() if p in self.roots]
        children = {e.second for e in edges}
        joined = {end for e in edges for end in (e.first, e.second)}
        return [
            *marked,
            *(n for n in self.prim_of if n in joined - children),
            *(n for n in self.prim_of if n in joined),
        ]

    def _base(self, link: str) -> DescribedJoint:
        """What holds nothing: the base of an articulation is free in the world."""
        return DescribedJoint(f"base_of_{link}", "floating", WORLD_LINK, link, self._X_WL(link), source=self.source)

    def _unjoined(
        self, links: Sequence[DescribedLink], joined: set[str], shaped: set[str]
    ) -> tuple[DescribedJoint, ...]:
        """Bodies without joints are free; those that show nothing are welded to the world, where they do not count."""
        return tuple(
            replace(self._base(link.name), kind="floating" if link.name in shaped else "fixed")
            for link in links
            if link.name not in joined
        )

    def _described(self, edge: _Edge, parent: str, child: str) -> DescribedJoint:
        """The joint from parent to child; where the file has it the other way round, its axis is turned round."""
        kind = _KINDS.get(str(edge.prim.GetTypeName()))
        if kind is None:
            self._refuse("robot/not-expressible", f"{edge.prim.GetTypeName()} is not carried over", edge.prim)
        forward = edge.first == parent
        axis = AXES[str(edge.prim.GetAttribute("physics:axis").Get(EARLIEST) or "X") if kind != "fixed" else "X"]
        limits = self._limits(edge.prim, kind or "fixed")
        rest = joint_position(kind or "fixed", axis, inverse(edge.X_W0) @ edge.X_W1, limits)
        X_WJ = edge.X_W1 if forward else edge.X_W0  # the frame that moves with the child
        X_CW = inverse(self._X_WL(child))
        axis_W = (1.0 if forward else -1.0) * (X_WJ[:3, :3] @ axis)
        described = DescribedJoint(
            self._name(edge.prim),
            kind or "fixed",
            parent,
            child,
            inverse(self._X_WL(parent)) @ self._X_WL(child),
            X_CW[:3, :3] @ axis_W,
            X_CW[:3, :3] @ X_WJ[:3, 3] + X_CW[:3, 3],
            reference=rest,
            limits=limits,
            source=self.source,
        )
        return replace(self._with_drive(described, edge.prim), mimic=self._mimic(edge.prim, kind or "fixed"))

    def _limits(self, prim: Usd.Prim, kind: JointKind) -> JointLimits | None:
        """Limits in radians and stage units; infinite ones are none."""
        if kind == "ball":
            cone = _number(prim, "physics:coneAngle0Limit", -1.0)
            return JointLimits(0.0, math.radians(cone)) if cone >= 0.0 else None
        if kind not in ("revolute", "prismatic"):
            return None
        lower, upper = _number(prim, "physics:lowerLimit", -math.inf), _number(prim, "physics:upperLimit", math.inf)
        if math.isnan(lower) or math.isnan(upper):
            self._refuse("robot/invalid-number", "a joint limit is no number", prim)
        if math.isinf(lower) or math.isinf(upper):
            return None
        return JointLimits(lower, upper) if kind == "prismatic" else JointLimits(*np.radians([lower, upper]).tolist())

    def _with_drive(self, joint: DescribedJoint, prim: Usd.Prim) -> DescribedJoint:
        """Damping, spring and largest effort of a drive, per radian; friction and armature as PhysX or Newton have."""
        angular = joint.kind == "revolute"
        name, per_unit = ("angular", math.degrees(1.0)) if angular else ("linear", 1.0)
        values: dict[str, float | None] = {}
        if prim.HasAPI(UsdPhysics.DriveAPI, name):
            drive = f"drive:{name}:physics:"
            force = _number(prim, f"{drive}maxForce", math.inf)
            values = {
                "stiffness": _number(prim, f"{drive}stiffness", 0.0) * per_unit,
                "damping": _number(prim, f"{drive}damping", 0.0) * per_unit,
                "spring_reference": _number(prim, f"{drive}targetPosition", 0.0) / per_unit,
                "effort": force if math.isfinite(force) else None,
            }
        for key, names in (
            ("friction", ("newton:friction", "mjc:frictionloss")),
            ("armature", ("newton:armature", "physxJoint:armature", "mjc:armature")),
        ):
            stated = [v for n in names if math.isfinite(v := _number(prim, n, math.nan))]
            values |= {key: stated[0]} if stated else {}
        speed = _number(prim, "physxJoint:maxJointVelocity", math.nan)
        if math.isfinite(speed):
            values["velocity"] = speed / per_unit
        values |= {key: v * self._si(key, angular) for key, v in values.items() if v is not None}
        if any(v is not None and not math.isfinite(v) for v in values.values()):
            self._refuse("robot/invalid-number", "a value of the drive is not finite", prim)
        return replace(joint, **values)

    def _si(self, quantity: str, angular: bool) -> float:
        """The factor to SI of a number of a drive that holds mass; positions and speeds keep the units of the stage."""
        if quantity in ("spring_reference", "velocity"):
            return 1.0
        kilograms, metres = UsdPhysics.GetStageKilogramsPerUnit(self.stage), UsdGeom.GetStageMetersPerUnit(self.stage)
        if angular:
            return kilograms * metres**2
        return kilograms * metres if quantity in ("effort", "friction") else kilograms

    def _mimic(self, prim: Usd.Prim, kind: JointKind) -> Mimic | None:
        """The joint that this one follows, as Newton's schema has it: coefficients per degree and metre."""
        targets = prim.GetRelationship(LEADER).GetForwardedTargets() if prim.HasRelationship(LEADER) else []
        leader = self.stage.GetPrimAtPath(targets[0]) if targets else None
        if leader is None or str(leader.GetPath()) not in self.joint_name:
            return None
        per_unit = math.degrees(1.0) if kind == "revolute" else 1.0
        leader_unit = math.degrees(1.0) if leader.IsA(UsdPhysics.RevoluteJoint) else 1.0
        multiplier = _number(prim, MULTIPLIER, 1.0) * leader_unit / per_unit
        return Mimic(self._name(leader), multiplier, _number(prim, OFFSET, 0.0) / per_unit)

    def _name(self, joint: Usd.Prim) -> str:
        return self.joint_name[str(joint.GetPath())]

    def _with_prims(self, reading: MechanismReading) -> MechanismReading:
        """The reading with the prim of each joint as its place."""
        if reading.mechanism is None:
            return reading
        paths = {name: path for path, name in self.joint_name.items()}
        placed = tuple(
            replace(j, where=self.where.model_copy(update={"prim": paths[j.source_name]}))
            for j in reading.mechanism.joints
        )
        return replace(reading, mechanism=replace(reading.mechanism, joints=placed))

    def _X_WL(self, link: str) -> FloatArray:
        if link == WORLD_LINK:
            return np.eye(4)
        X = column_matrix(self.cache.GetLocalToWorldTransform(self.prim_of[link]))
        return pose(_rotation(X), X[:3, 3])

    def _refuse(self, code: str, headline: str, prim: Usd.Prim) -> None:
        where = self.where.model_copy(update={"prim": str(prim.GetPath())})
        raise InvalidInput(finding(code, headline, where=where, severity=Severity.ERROR))


def _rotation(X: FloatArray) -> FloatArray:
    """The rotation (3, 3) of a pose with scale or shear, by polar decomposition; of a mirrored one the nearest."""
    u, _, v = np.linalg.svd(X[:3, :3])
    u[:, -1] *= np.sign(np.linalg.det(u @ v)) or 1.0
    return u @ v


def _enabled(prim: Usd.Prim) -> bool:
    return _flag(prim, "physics:rigidBodyEnabled", True)


def _flag(prim: Usd.Prim, name: str, fallback: bool) -> bool:
    value = prim.GetAttribute(name).Get(EARLIEST) if prim.HasAttribute(name) else None
    return fallback if value is None else bool(value)


def _number(prim: Usd.Prim, name: str, fallback: float) -> float:
    value = prim.GetAttribute(name).Get(EARLIEST) if prim.HasAttribute(name) else None
    return fallback if value is None else float(value)
