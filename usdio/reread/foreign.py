"""Reads a package that Mana did not write as suites of acceptance take it: UsdPhysics as SimReady allows it.

`usdio.reread.body` reads what Mana releases, and refuses everything else. This reader takes other units and up axes,
bodies and colliders anywhere in the file, polygons, instances, and mass or contact values that are not stated. Each
conversion and each value that is assumed is a finding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdPhysics

from geom.convex.placement import moved_shape
from geom.convex.support_function import surface
from geom.mass.inertia import moved
from geom.pose import apply, inverse, pose, shortest_rotation
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.package import GraspLines
from schemas.physics import Contact, RigidBody
from usdio.quiet import quiet
from usdio.read.gprim_placement import column_matrix
from usdio.read.meshes import EARLIEST, IMPLICIT_SHAPES
from usdio.read.physics import authored, combine_rule, contact_material, kilograms_per_unit
from usdio.read.stage_metadata import meters_per_unit, up_axis
from usdio.reread.body import Linkage, RereadPackage, first_authored
from usdio.reread.foreign_mass import Collider, StageUnits, foreign_mass
from usdio.reread.foreign_shapes import EVEN, foreign_shapes, placed_surface, unsupported
from usdio.reread.mechanism import filtered_pairs, mechanism_between
from usdio.stage import open_stage

# Without a contact material: what SimReady's runtime benchmark sets on its slope, and PhysX's default material.
UNSTATED_FRICTION: Final = 0.5
GRASPS: Final = "grasp_identifier"  # SimReady GSP.001
_UP: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_OFF_CENTRE: Final = 1e-3  # of the diagonal, as acceptance requires of a package


@dataclass(frozen=True)
class ForeignPackage:
    """The package in the asset frame (metres, z up, origin at the bottom centre), lines of grasps in the same frame,
    and a finding per conversion and assumption.
    """

    content: RereadPackage
    grasp_lines_m: GraspLines
    findings: tuple[Diagnostic, ...]


def reread_foreign(main_file: Path) -> ForeignPackage:
    """The package with this main USD file.

    Raises InvalidInput: `asset/package-invalid` for a file that OpenUSD cannot open or refuses to read,
    `asset/foreign-unsupported` for what cannot be exercised, and as the readers of meshes and metadata do.
    """
    with quiet(), np.errstate(all="ignore"):
        stage = open_stage(main_file)  # Held: prims end with their stage.
        try:
            return _Reader(stage, main_file).read()
        except Tf.ErrorException as error:
            reason = str(error.args[0] if error.args else error).rpartition(" : ")[2].strip("' \n")
            where = Location(file=main_file.name)
            refused = finding("asset/package-invalid", "OpenUSD refuses a value in the file", where=where)
            raise InvalidInput(refused.model_copy(update={"value": reason[:300]})) from error


@dataclass
class _Reader:
    stage: Usd.Stage
    main_file: Path
    findings: list[Diagnostic] = field(default_factory=list[Diagnostic])

    def read(self) -> ForeignPackage:
        prims = list(self._prims())
        bodies = [prim for prim in prims if _is_body(prim)]
        if not bodies:
            raise unsupported("no rigid body that moves", self._where())
        units, X_AW = self._frame()
        visual = self._visual(prims, X_AW)
        colliders = self._colliders(bodies, prims, X_AW)
        if not len(visual[1]):
            self._note("asset/foreign-converted", "nothing is visible: the colliders stand for the visible surface")
            visual = _merged([surface(s) for c in colliders.values() for one in c for s in one.shapes])
        shift = self._to_bottom_centre(visual[0])
        X_AW = shift @ X_AW
        visual = apply(shift, visual[0]), visual[1]
        for own in colliders.values():
            own[:] = [Collider(one.prim, tuple(moved_shape(s, shift) for s in one.shapes)) for one in own]
        lines = self._grasp_lines(prims, X_AW)
        if len(bodies) == 1:
            body, contacts = self._body(bodies[0], colliders[bodies[0].GetPath()], X_AW, units)
            content = RereadPackage(body, contacts, *visual)
        else:
            content = self._linkage(prims, bodies, colliders, X_AW, units, visual)
        return ForeignPackage(content, lines, _grouped(self.findings))

    def _prims(self) -> Iterator[Usd.Prim]:
        """All prims with those of instances, without copies of point instancers."""
        prims = iter(Usd.PrimRange(self.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
        for prim in prims:
            if prim.IsA(UsdGeom.PointInstancer):
                self._note("asset/foreign-converted", "the copies of a point instancer were left out", prim)
                prims.PruneChildren()
            yield prim

    def _frame(self) -> tuple[StageUnits, FloatArray]:
        """Units of the stage, and X_AW (4, 4) from its world to metres with z up."""
        lengths, axis = meters_per_unit(self.stage, self._where()), up_axis(self.stage, self._where())
        self.findings += [*lengths.diagnostics, *axis.diagnostics]
        units = StageUnits(lengths.value.value, kilograms_per_unit(self.stage))
        if units.metres != 1.0:
            headline = f"the unit of length is {units.metres:g} m ({lengths.value.method}): scaled to metres"
            self._note("asset/foreign-converted", headline)
        if axis.value.value != "z":
            headline = f"{axis.value.value.upper()} is up ({axis.value.method}): turned until z is up"
            self._note("asset/foreign-converted", headline)
        X_AW = pose(shortest_rotation(np.array(_UP[axis.value.value]), np.array(_UP["z"])))
        X_AW[:3, :3] *= units.metres
        return units, X_AW

    def _visual(self, prims: Sequence[Usd.Prim], X_AW: FloatArray) -> tuple[FloatArray, IntArray]:
        drawn = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
        surfaces: list[tuple[FloatArray, IntArray]] = []
        for prim in prims:
            if str(prim.GetTypeName()) not in ("Mesh", *IMPLICIT_SHAPES):
                continue
            imageable = UsdGeom.Imageable(prim)
            if imageable.ComputePurpose() not in drawn or imageable.ComputeVisibility() == UsdGeom.Tokens.invisible:
                continue
            placed = placed_surface(prim, X_AW @ _world(prim), self._where(prim))
            surfaces += [] if placed is None else [placed]
        return _merged(surfaces)

    def _colliders(
        self, bodies: Sequence[Usd.Prim], prims: Sequence[Usd.Prim], X_AW: FloatArray
    ) -> dict[object, list[Collider]]:
        """The colliders of each body by its path; those of none are noted."""
        owned: dict[object, list[Collider]] = {body.GetPath(): [] for body in bodies}
        loose = 0
        for prim in prims:
            if not prim.HasAPI(UsdPhysics.CollisionAPI):
                continue
            if not UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
                continue
            owner = prim
            while owner and not _is_body(owner):
                owner = owner.GetParent()
            if not owner:
                loose += 1
                continue
            shapes = foreign_shapes(prim, X_AW @ _world(prim), self._where(prim), self.findings.append)
            owned[owner.GetPath()].append(Collider(prim, shapes))
        if loose:
            self._note("asset/foreign-converted", f"{loose} colliders belong to no moving body and were left out")
        for body in bodies:
            if not owned[body.GetPath()]:
                raise unsupported("a body without colliders", self._where(body))
        return owned

    def _to_bottom_centre(self, points: FloatArray) -> FloatArray:
        """The move (4, 4) of the asset frame to the bottom centre of the visible points, identity where it is there."""
        low, high = points.min(axis=0), points.max(axis=0)
        bottom = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
        away = float(np.linalg.norm(bottom))
        if not away > _OFF_CENTRE * float(np.linalg.norm(high - low)):
            return pose()
        headline = f"the origin is {away:.3g} m from the bottom centre of the object: moved there"
        self._note("asset/foreign-converted", headline)
        return pose(None, -bottom)

    def _body(
        self, prim: Usd.Prim, colliders: Sequence[Collider], X_AW: FloatArray, units: StageUnits
    ) -> tuple[RigidBody, tuple[Contact, ...]]:
        """The body in the asset frame, and the contact of each of its shapes."""
        if UsdPhysics.RigidBodyAPI(prim).GetKinematicEnabledAttr().Get():
            self._note("asset/foreign-converted", "the body is kinematic in the file: here it moves freely", prim)
        where = self._where(prim)
        mass = foreign_mass(prim, colliders, X_AW @ _world(prim), units, where, self.findings.append)
        bound = {c.prim.GetPath(): contact_material(c.prim) for c in colliders}
        stated = [UsdPhysics.MaterialAPI(m) for m in bound.values() if m is not None]
        if len(stated) < len(bound):
            headline = (
                f"{len(bound) - len(stated)} of {len(bound)} colliders have no contact material: friction "
                f"{UNSTATED_FRICTION:g}, as PhysX's default material and SimReady's slope have it; restitution 0"
            )
            self._note("asset/foreign-assumed", headline, prim)
        contacts = {path: self._contact(material) for path, material in bound.items()}
        # Of several the first authored, as in packages of Mana.
        chosen = self._contact(first_authored(stated).GetPrim()) if stated else self._contact(None)
        shapes = tuple(shape for c in colliders for shape in c.shapes)
        each = tuple(contacts[c.prim.GetPath()] for c in colliders for _ in c.shapes)
        return RigidBody(prim.GetName(), shapes, mass, chosen), each

    def _contact(self, material: Usd.Prim | None) -> Contact:
        if material is None:
            return Contact(static_friction=UNSTATED_FRICTION, dynamic_friction=UNSTATED_FRICTION, restitution=0.0)
        api, where = UsdPhysics.MaterialAPI(material), self._where(material)
        names = ("staticFriction", "dynamicFriction", "restitution")
        values = [float(material.GetAttribute(f"physics:{name}").Get() or 0.0) for name in names]
        if not all(math.isfinite(value) and value >= 0.0 for value in values):
            raise unsupported("a contact material whose friction or restitution is no number from 0 on", where)
        unstated = [name for name in names[:2] if authored(material, f"physics:{name}") is None]
        headline = f"the contact material states no {' and no '.join(unstated)}: 0, as UsdPhysics has it"
        if unstated and all(f.headline != headline or f.where != where for f in self.findings):
            self._note("asset/foreign-assumed", headline, material)
        combine = api.GetPrim().GetCustomDataByKey("mana:combine") or combine_rule(material)
        return Contact(
            static_friction=values[0], dynamic_friction=values[1], restitution=min(values[2], 1.0), combine=combine
        )

    def _linkage(
        self,
        prims: Sequence[Usd.Prim],
        bodies: Sequence[Usd.Prim],
        colliders: dict[object, list[Collider]],
        X_AW: FloatArray,
        units: StageUnits,
        visual: tuple[FloatArray, IntArray],
    ) -> RereadPackage:
        """Several bodies, which joints must connect; links keep their origins and take the axes of the asset frame."""
        names = [body.GetName() for body in bodies]
        paths = {body.GetPath() for body in bodies}
        joints = [p for p in prims if p.IsA(UsdPhysics.Joint) and UsdPhysics.Joint(p).GetJointEnabledAttr().Get()]
        held = [joint for joint in joints if _holds_in_world(joint, paths)]
        for joint in held:
            self._note("asset/foreign-converted", "a joint that fixes a body to the world was left out", joint)
        joints = [joint for joint in joints if joint not in held]
        if not joints:
            raise unsupported(f"{len(bodies)} bodies without joints: each needs a file of its own", self._where())
        if len(set(names)) < len(names):
            raise unsupported("several bodies of the same name", self._where())
        if units.metres != 1.0:
            raise unsupported("joints in other units than metres", self._where())
        frames: dict[str, FloatArray] = {}
        scales: dict[str, FloatArray] = {}
        for body in bodies:
            X_AB = X_AW @ _world(body)
            scale = np.linalg.norm(X_AB[:3, :3], axis=0)
            rotation = X_AB[:3, :3] / scale
            if not np.linalg.norm(rotation.T @ rotation - np.eye(3)) <= EVEN or np.linalg.det(rotation) < 0.0:
                raise unsupported("joints between bodies that are sheared or mirrored", self._where(body))
            if np.abs(scale - 1.0).max() > EVEN:
                frames[body.GetName()], scales[body.GetName()] = pose(rotation, X_AB[:3, 3]), scale
            else:
                frames[body.GetName()] = X_AB
        mechanism = mechanism_between(frames, joints, self.main_file, scales)
        by_name = {body.GetName(): body for body in bodies}
        links: list[RigidBody] = []
        contacts: list[Contact] = []
        for link in mechanism.links:
            prim = by_name[link.name]
            body, each = self._body(prim, colliders[prim.GetPath()], X_AW, units)
            X_LA = inverse(pose(None, link.origin))
            shapes = tuple(moved_shape(shape, X_LA) for shape in body.shapes)
            links.append(RigidBody(body.name, shapes, moved(body.mass, X_LA), body.contact))
            contacts += each
        root = self.stage.GetDefaultPrim()
        linkage = Linkage(root.GetName() if root else self.main_file.stem, mechanism, tuple(links))
        pairs = filtered_pairs(list(bodies))
        return RereadPackage(linkage.held(), tuple(contacts), *visual, linkage, pairs)

    def _grasp_lines(self, prims: Sequence[Usd.Prim], X_AW: FloatArray) -> GraspLines:
        """The ends of the line of each `grasp_identifier*`, from its own points or those of a child."""
        lines: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {}
        for prim in prims:
            owner = prim if prim.GetName().startswith(GRASPS) else prim.GetParent()
            if not owner or not owner.GetName().startswith(GRASPS) or not prim.HasAttribute("points"):
                continue
            points = np.asarray(prim.GetAttribute("points").Get(EARLIEST), dtype=np.float64).reshape(-1, 3)
            if len(points) < 2 or not np.isfinite(points).all():
                self._note("asset/foreign-converted", "a grasp without a line of two points was left out", prim)
                continue
            first, last = apply(X_AW @ _world(prim), points[[0, -1]]).tolist()
            lines.setdefault(str(owner.GetPath()), (tuple(first), tuple(last)))
        return tuple(lines.values())

    def _where(self, prim: Usd.Prim | None = None) -> Location:
        return Location(file=self.main_file.name, prim=None if prim is None else str(prim.GetPath()))

    def _note(self, code: str, headline: str, prim: Usd.Prim | None = None) -> None:
        self.findings.append(finding(code, headline, where=self._where(prim)))


def _grouped(findings: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Findings of the same words once, at the first place, with the number of the others."""
    groups: dict[tuple[str, str], list[Diagnostic]] = {}
    for one in findings:
        groups.setdefault((one.code, one.headline), []).append(one)
    return tuple(
        same[0] if len(same) == 1 else same[0].model_copy(update={"headline": f"{words} (at {len(same)} prims)"})
        for (_, words), same in groups.items()
    )


def _is_body(prim: Usd.Prim) -> bool:
    return prim.HasAPI(UsdPhysics.RigidBodyAPI) and bool(UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get())


def _holds_in_world(joint: Usd.Prim, bodies: set[object]) -> bool:
    """Whether a fixed joint has a body at one end only."""
    if not joint.IsA(UsdPhysics.FixedJoint):
        return False
    api = UsdPhysics.Joint(joint)
    ends = [set(relation.GetTargets()) & bodies for relation in (api.GetBody0Rel(), api.GetBody1Rel())]
    return not (ends[0] and ends[1])


def _world(prim: Usd.Prim) -> FloatArray:
    return column_matrix(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))


def _merged(surfaces: Sequence[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    points, triangles, offset = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int32)], 0
    for own, corners in surfaces:
        points.append(own)
        triangles.append(np.asarray(corners, dtype=np.int32) + np.int32(offset))
        offset += len(own)
    return np.concatenate(points), np.concatenate(triangles)
