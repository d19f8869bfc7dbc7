"""The moving structure of a description: welded links are one link, joints to the world and empty leaves are left out.

Input is a `RobotDescription`; output a `Mechanism` in the frame M of the description's root, at the rest state: every
joint at its reference, or at the limit next to it. A description whose links do not move against each other has none.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from formats.kinematics import motion
from formats.tree import breadth_first, joints_of
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.identifiers import unique_identifiers
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismJointKind, MechanismLink
from schemas.outcome import INTAKE, Repair
from schemas.robot_description import WORLD_LINK, DescribedJoint, JointLimits, RobotDescription

MAX_LINKS = 256  # moving bodies; engines take no larger articulation (PhysX: 64 links in one, PyBullet: 128)
RESERVED_NAMES = ("Materials", "PhysicsMaterials", "Joints", "Visuals", "Colliders")  # scopes beside the links in USD
_KINDS: Mapping[str, MechanismJointKind] = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "ball": "ball",
}


@dataclass(frozen=True)
class MechanismReading:
    """What moves in a description, and where its links are at rest.

    mechanism  None where all that has a shape is one body.
    link_of    name of the mechanism's link of each source link; "" where there is no mechanism.
    X_ML       (4, 4) of each source link at rest, in the root's frame.
    """

    mechanism: Mechanism | None
    link_of: Mapping[str, str]
    X_ML: Mapping[str, FloatArray]
    notes: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def read_mechanism(
    description: RobotDescription, shaped: Iterable[str], loops: Sequence[DescribedJoint] = ()
) -> MechanismReading:
    """The mechanism of a description; `shaped` are the links that have a usable shape.

    `loops` are joints beside the tree, which close loops (USD); the rest state is then the one that the file has.

    Raises InvalidInput: `robot/empty-link` for a link without a shape in the middle of a chain, `robot/several-roots`
    for bodies that move freely in one file, `robot/not-expressible` for planar joints and joints that share a child,
    `robot/too-many-links`.
    """
    return _Reduction(description, frozenset(shaped), tuple(loops)).reading()


@dataclass
class _Joint:
    """A joint while the structure is reduced; `lock` is the position of one that cannot move."""

    described: DescribedJoint
    limits: JointLimits | None
    kind: str
    lock: float | None = None

    @property
    def moves(self) -> bool:
        return self.described.moves and self.lock is None


@dataclass
class _Reduction:
    """One pass: limits made usable, rest state, welds, then joints between what is left."""

    description: RobotDescription
    shaped: frozenset[str]
    loops: tuple[DescribedJoint, ...] = ()
    notes: list[Diagnostic] = field(default_factory=list[Diagnostic])
    repairs: list[Repair] = field(default_factory=list[Repair])

    def reading(self) -> MechanismReading:
        joints = {j.name: self._usable(j) for j in self.description.joints}
        carriers = joints_of(self.description.joints)
        order = breadth_first(self.description)
        group = self._welded(order, joints, carriers)
        rest = self._rest(joints)
        X_ML, X_MJ = self._placed(order, carriers, rest)
        staying, root = self._reduced(order, joints, carriers, group)
        if len({group[link] for link in order if group[link] in staying}) <= 1:
            return MechanismReading(None, dict.fromkeys(order, ""), X_ML, tuple(self.notes), tuple(self.repairs))
        if len(staying) > MAX_LINKS:
            self._refuse("robot/too-many-links", f"{len(staying)} links move", None, len(staying), MAX_LINKS)
        names = self._names(order, group, staying)
        mechanism = self._mechanism(order, joints, carriers, group, root, names, rest, X_MJ, X_ML)
        link_of = {link: names[group[link]] if group[link] in staying else names[root] for link in order}
        return MechanismReading(mechanism, link_of, X_ML, tuple(self.notes), tuple(self.repairs))

    def _usable(self, joint: DescribedJoint) -> _Joint:
        """The joint with limits in order; equal ones lock it, a hinge without limits turns without end."""
        limits, kind = joint.limits, joint.kind
        if kind == "revolute" and limits is None:
            if self.description.format == "urdf":  # Elsewhere a hinge without limits is endless by the format.
                repair = _repair("free_hinge", "robot/missing-limit", joint, limits="none", now="continuous")
                self.repairs.append(repair)
            kind = "continuous"
        if kind not in ("revolute", "prismatic") or limits is None:
            return _Joint(joint, None if kind == "continuous" else limits, kind)
        if limits.lower > limits.upper:
            text = f"{limits.lower:g} .. {limits.upper:g}"
            limits = JointLimits(limits.upper, limits.lower)
            now = f"{limits.lower:g} .. {limits.upper:g}"
            self.repairs.append(_repair("swap_limits", "robot/reversed-limits", joint, limits=text, now=now))
        if limits.lower == limits.upper:
            text = f"{limits.lower:g} .. {limits.upper:g}"
            self.repairs.append(_repair("weld_locked", "robot/reversed-limits", joint, limits=text, now="fixed"))
            return _Joint(joint, limits, kind, limits.lower)
        return _Joint(joint, limits, kind)

    def _welded(
        self, order: Sequence[str], joints: Mapping[str, _Joint], carriers: Mapping[str, list[DescribedJoint]]
    ) -> dict[str, str]:
        """For each link the first link, in breadth-first order, that it is welded to."""
        group: dict[str, str] = {order[0]: order[0]}
        for link in order[1:]:
            carried_by = [joints[j.name] for j in carriers[link]]
            parent = carried_by[0].described.parent
            group[link] = group[parent] if not any(j.moves for j in carried_by) else link
        return group

    def _rest(self, joints: Mapping[str, _Joint]) -> dict[str, float]:
        """Positions of the rest state: the reference, or the next position within the limits, of followers too."""
        if self.loops:
            return {name: j.described.reference for name, j in joints.items()}
        span = {
            name: (j.limits.lower, j.limits.upper) if j.limits is not None else (-np.inf, np.inf)
            for name, j in joints.items()
        }
        leaders = {name: self._leader(joints, name) for name in joints}
        narrowed = dict(span)
        for name, (leader, gain, offset) in leaders.items():
            if leader != name and gain != 0.0:
                low, high = sorted((bound - offset) / gain for bound in span[name])
                least, most = narrowed[leader]
                if max(least, low) <= min(most, high):
                    narrowed[leader] = max(least, low), min(most, high)
        rest: dict[str, float] = {}
        for name, j in joints.items():
            leader, gain, offset = leaders[name]
            at = float(np.clip(joints[leader].described.reference, *narrowed[leader]))
            rest[name] = j.lock if j.lock is not None else gain * at + offset
        return rest

    def _leader(self, joints: Mapping[str, _Joint], name: str) -> tuple[str, float, float]:
        """The joint that moves by itself which `name` follows, with gain and offset along the chain."""
        gain, offset, at = 1.0, 0.0, name
        while (mimic := joints[at].described.mimic) is not None:
            offset += gain * mimic.offset
            gain *= mimic.multiplier
            at = mimic.joint
        return at, gain, offset

    def _placed(
        self, order: Sequence[str], carriers: Mapping[str, list[DescribedJoint]], rest: Mapping[str, float]
    ) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """X_ML of links and X_MJ of joints (the child's frame before the joint moves it), at rest."""
        X_ML: dict[str, FloatArray] = {order[0]: np.eye(4)}
        X_MJ: dict[str, FloatArray] = {}
        for link in order[1:]:
            at = X_ML[carriers[link][0].parent] @ carriers[link][0].X_PC
            for joint in carriers[link]:
                X_MJ[joint.name] = at
                if joint.kind in ("revolute", "continuous", "prismatic"):
                    at = at @ motion(joint, rest[joint.name])
            X_ML[link] = at
        return X_ML, X_MJ

    def _reduced(
        self,
        order: Sequence[str],
        joints: Mapping[str, _Joint],
        carriers: Mapping[str, list[DescribedJoint]],
        group: Mapping[str, str],
    ) -> tuple[set[str], str]:
        """The groups that stay, and the root among them: without empty leaves and without an empty base."""
        members: dict[str, list[str]] = {}
        for link in order:
            members.setdefault(group[link], []).append(link)
        full = {g for g, links in members.items() if self.shaped.intersection(links)}
        parent = {g: group[carriers[g][0].parent] for g in members if g != order[0]}
        below: dict[str, list[str]] = {}
        for g, p in parent.items():
            below.setdefault(p, []).append(g)
        staying = set(members)
        for g in reversed(list(members)):  # Children come before their parents.
            if g not in full and g != order[0] and not any(child in staying for child in below.get(g, ())):
                staying.discard(g)
                for joint in carriers[g]:
                    headline = f"joint '{joint.name}' moves link '{joint.child}', which has no shape; it was left out"
                    self._note("robot/empty-link", headline, joint, Severity.WARNING)
        root = order[0]
        while root not in full:
            children = [g for g in below.get(root, ()) if g in staying]
            if len(children) != 1:
                break
            self._leave_base(carriers[children[0]])
            staying.discard(root)
            root = children[0]
        self._require_links(staying, full, root, carriers)
        return staying, root

    def _leave_base(self, joints: Sequence[DescribedJoint]) -> None:
        """A note on joints between the world and the object: a package holds the object, not its place."""
        for joint in joints:
            if joint.kind != "floating":
                headline = f"joint '{joint.name}' moves the whole object against the world; it was left out"
                self._note("robot/base-joint", headline, joint)

    def _require_links(
        self, staying: set[str], full: set[str], root: str, carriers: Mapping[str, list[DescribedJoint]]
    ) -> None:
        """Raises InvalidInput for links and joints that no package can hold."""
        for g in sorted(staying - {root}):
            first = carriers[g][0]
            if first.kind == "floating":
                headline = f"joint '{first.name}' leaves link '{g}' free: the file holds several objects"
                self._refuse("robot/several-roots", headline, first, g)
            if first.kind == "planar":
                self._refuse("robot/not-expressible", f"joint '{first.name}' is planar, which USD has not", first)
            if len([j for j in carriers[g] if j.moves]) > 1:
                headline = f"link '{g}' is carried by {len(carriers[g])} joints; between them there is no body"
                self._refuse("robot/empty-link", headline, carriers[g][1], g)
        for g in sorted(staying - full):
            joint = carriers[g][0] if g in carriers else None
            self._refuse("robot/empty-link", f"link '{g}' carries others and has no shape", joint, g)

    def _names(self, order: Sequence[str], group: Mapping[str, str], staying: set[str]) -> dict[str, str]:
        """An identifier for each group, from its first member with a shape."""
        first: dict[str, str] = {}
        for link in order:
            better = link in self.shaped or group[link] not in first
            if group[link] in staying and better and first.get(group[link]) not in self.shaped:
                first[group[link]] = link
        groups = [g for g in order if g in first]
        chosen = unique_identifiers([*RESERVED_NAMES, *(first[g] for g in groups)], "link")
        return dict(zip(groups, list(chosen)[len(RESERVED_NAMES) :], strict=True))

    def _mechanism(
        self,
        order: Sequence[str],
        joints: Mapping[str, _Joint],
        carriers: Mapping[str, list[DescribedJoint]],
        group: Mapping[str, str],
        root: str,
        names: Mapping[str, str],
        rest: Mapping[str, float],
        X_MJ: Mapping[str, FloatArray],
        X_ML: Mapping[str, FloatArray],
    ) -> Mechanism:
        groups = [root, *(g for g in order if g in names and g != root)]
        moving = [joints[j.name] for g in groups[1:] for j in carriers[g] if joints[j.name].moves]
        chosen = unique_identifiers([j.described.name for j in moving], "joint")
        identifiers = dict(zip([j.described.name for j in moving], chosen, strict=True))
        joints_here: list[MechanismJoint] = []
        for joint in sorted(moving, key=lambda j: self.description.joints.index(j.described)):
            d, X = joint.described, X_MJ[joint.described.name]
            anchor = X[:3, :3] @ d.anchor_C + X[:3, 3]
            joints_here.append(
                MechanismJoint(
                    name=identifiers[d.name],
                    kind=_KINDS[joint.kind],
                    parent=names[group[d.parent]],
                    child=names[group[d.child]],
                    anchor=anchor,
                    axis=X[:3, :3] @ d.axis_C,
                    rest=rest[d.name],
                    limits=None if joint.limits is None else (joint.limits.lower, joint.limits.upper),
                    effort=d.effort if d.effort else None,
                    velocity=d.velocity if d.velocity else None,
                    damping=max(d.damping, 0.0),
                    friction=max(d.friction, 0.0),
                    armature=max(d.armature, 0.0),
                    stiffness=max(d.stiffness, 0.0),
                    spring_rest=d.spring_reference,
                    coupling=self._coupling(d, identifiers),
                    source_name=d.name,
                    where=d.source.location,
                )
            )
        origins = {joint.child: joint.anchor for joint in joints_here}
        joints_here += self._closing(names, group, X_ML)
        links = tuple(
            MechanismLink(
                names[g], origins.get(names[g], np.zeros(3)), tuple(link for link in order if group[link] == g)
            )
            for g in groups
        )
        fixed = self.description.root == WORLD_LINK and group[self.description.root] == root
        return Mechanism(links, tuple(joints_here), fixed)

    def _closing(
        self, names: Mapping[str, str], group: Mapping[str, str], X_ML: Mapping[str, FloatArray]
    ) -> list[MechanismJoint]:
        """The joints that close loops, between links that stay and are not one."""
        joints_here: list[MechanismJoint] = []
        for loop in self.loops:
            ends = [group[loop.parent], group[loop.child]]
            if ends[0] == ends[1] or not names.keys() >= set(ends):
                continue
            usable, X = self._usable(loop), X_ML[loop.child]
            headline = f"joint '{loop.name}' closes a loop; a URDF, which is a tree, leaves it out"
            self._note("robot/closing-joint", headline, loop)
            joints_here.append(
                MechanismJoint(
                    name=loop.name,
                    kind=_KINDS[usable.kind],
                    parent=names[ends[0]],
                    child=names[ends[1]],
                    anchor=X[:3, :3] @ loop.anchor_C + X[:3, 3],
                    axis=X[:3, :3] @ loop.axis_C,
                    rest=loop.reference,
                    limits=None if usable.limits is None else (usable.limits.lower, usable.limits.upper),
                    damping=max(loop.damping, 0.0),
                    friction=max(loop.friction, 0.0),
                    closes_loop=True,
                    source_name=loop.name,
                    where=loop.source.location,
                )
            )
        return joints_here

    def _coupling(self, joint: DescribedJoint, identifiers: Mapping[str, str]) -> JointCoupling | None:
        """What the joint follows; None, with a note, where that joint does not move here."""
        if joint.mimic is None:
            return None
        if joint.mimic.joint not in identifiers:
            headline = f"joint '{joint.name}' follows '{joint.mimic.joint}', which does not move; it moves by itself"
            self._note("robot/base-joint", headline, joint)
            return None
        return JointCoupling(identifiers[joint.mimic.joint], joint.mimic.multiplier, joint.mimic.offset)

    def _note(self, code: str, headline: str, joint: DescribedJoint, severity: Severity | None = None) -> None:
        self.notes.append(finding(code, headline, where=joint.source.location, severity=severity))

    def _refuse(
        self,
        code: str,
        headline: str,
        joint: DescribedJoint | None,
        value: str | float | None = None,
        bound: float | None = None,
    ) -> None:
        source = self.description.source if joint is None else joint.source
        raise InvalidInput(finding(code, headline, where=source.location, value=value, bound=bound))


def _repair(name: str, code: str, joint: DescribedJoint, *, limits: str, now: str) -> Repair:
    before: dict[str, float | int | str] = {"joint": joint.name, "limits": limits}
    return Repair(name=name, code=code, stage=INTAKE, before=before, after={"joint": joint.name, "limits": now})
