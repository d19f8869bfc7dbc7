"""A package that is about to be damaged: a copy on disk, its USD stage and its record. Knows nothing of acceptance.

Edits are opinions in the root layer and values of the record; the record's hash of that layer is made to fit, as a
careful vandal would.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from schemas.arrays import FloatArray


@dataclass
class Victim:
    """A copy of a package, open for edits until `save`."""

    folder: Path
    stage: Usd.Stage
    record: dict[str, Any]
    random: np.random.Generator

    @property
    def root(self) -> Usd.Prim:
        """The default prim."""
        return self.stage.GetDefaultPrim()

    @property
    def bodies(self) -> list[Usd.Prim]:
        """The rigid bodies."""
        return [prim for prim in self.stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]

    @property
    def colliders(self) -> list[Usd.Prim]:
        """The collision shapes."""
        return [prim for prim in self.stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)]

    @property
    def joints(self) -> list[Usd.Prim]:
        """Joints that move, by their type."""
        kinds = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint")
        return [prim for prim in self.stage.Traverse() if prim.GetTypeName() in kinds]

    @property
    def materials(self) -> list[Usd.Prim]:
        """The contact materials."""
        return [prim for prim in self.stage.Traverse() if prim.HasAPI(UsdPhysics.MaterialAPI)]

    @property
    def extent_m(self) -> FloatArray:
        """(3,) size of the object on record."""
        return np.array(self.record["geometry"]["extent_m"]["value"])

    @property
    def size_m(self) -> float:
        """Its diagonal."""
        return float(np.linalg.norm(self.extent_m))

    @property
    def grasps(self) -> list[dict[str, Any]]:
        """Grasps on record that did not fail, as they stand there."""
        values = [evidence["value"] for evidence in self.record["affordances"]]
        return [v for v in values if v["kind"] == "grasp" and v["trial"] != "not_held"]

    @property
    def roles(self) -> set[str]:
        """Roles on record that count."""
        return {e["value"] for e in self.record["semantics"]["roles"] if e["confidence"] >= 0.5}

    def anchors(self, kind: str) -> list[dict[str, Any]]:
        """Anchors on record of a kind, `surface` or `volume`."""
        return [e["value"] for e in self.record["anchors"] if e["value"]["kind"] == kind]

    def points_of(self, collider: Usd.Prim) -> FloatArray:
        """(n, 3) points of a hull in the frame of its body; of another shape the corners of its box."""
        body = self.body_of(collider)
        cache = UsdGeom.XformCache()
        to_body = cache.GetLocalToWorldTransform(collider) * cache.GetLocalToWorldTransform(body).GetInverse()
        if collider.IsA(UsdGeom.Mesh):
            local = np.asarray(UsdGeom.Mesh(collider).GetPointsAttr().Get(), dtype=np.float64)
        else:
            bound = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(collider), Usd.TimeCode.Default())
            low, high = np.asarray(bound, dtype=np.float64)
            local = np.array(
                [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
            )
        matrix = np.array(to_body)
        return local @ matrix[:3, :3] + matrix[3, :3]

    def body_of(self, prim: Usd.Prim) -> Usd.Prim:
        """The rigid body that a prim belongs to."""
        while prim and not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            prim = prim.GetParent()
        return prim

    def colliders_of(self, body: Usd.Prim) -> list[Usd.Prim]:
        """The collision shapes of one body."""
        return [c for c in self.colliders if self.body_of(c) == body]

    def moved(self, joint: Usd.Prim) -> Usd.Prim:
        """The body that a joint moves."""
        return self.stage.GetPrimAtPath(UsdPhysics.Joint(joint).GetBody1Rel().GetTargets()[0])

    def remove(self, prim: Usd.Prim) -> None:
        """Take a prim off the stage."""
        prim.SetActive(False)

    def transform(self, prim: Usd.Prim, offset_m: FloatArray, scale: float = 1.0) -> None:
        """Move a prim by an offset in the frame of its parent, and scale it about its own middle."""
        points = self.points_of(prim)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        shift = middle * (1.0 - scale) + offset_m
        matrix = Gf.Matrix4d(1.0).SetScale(scale) * Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*shift.tolist()))
        xform = UsdGeom.Xformable(prim)
        before = xform.GetLocalTransformation()
        xform.ClearXformOpOrder()
        xform.AddTransformOp(opSuffix="sabotage").Set(before * matrix)

    def add_box(self, body: Usd.Prim, name: str, centre_m: FloatArray, edges_m: FloatArray) -> Usd.Prim:
        """A box collider on a body, with the contact material of its first collider."""
        first = self.colliders_of(body)[0]
        cube = UsdGeom.Cube.Define(self.stage, first.GetPath().GetParentPath().AppendChild(name))
        cube.CreateSizeAttr(1.0)
        cube.CreateExtentAttr([(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)])
        cube.CreatePurposeAttr(UsdGeom.Tokens.guide)
        matrix = Gf.Matrix4d(1.0).SetScale(Gf.Vec3d(*edges_m.tolist())) * Gf.Matrix4d(1.0).SetTranslate(
            Gf.Vec3d(*centre_m.tolist())
        )
        cube.AddTransformOp().Set(matrix)
        prim = cube.GetPrim()
        UsdPhysics.CollisionAPI.Apply(prim)
        for relationship in first.GetRelationships():
            if relationship.GetName().startswith("material:binding"):
                prim.CreateRelationship(relationship.GetName(), custom=False).SetTargets(relationship.GetTargets())
        prim.ApplyAPI("MaterialBindingAPI")
        return prim

    def save(self) -> None:
        """Write layer and record."""
        layer = self.stage.GetRootLayer()
        layer.Save()
        path = Path(layer.realPath)
        self.record["hashes"][path.relative_to(self.folder).as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
        (self.folder / "record.json").write_text(json.dumps(self.record))


def victim(package: Path, target: Path, seed: int) -> Victim:
    """A copy of `package` at `target`, whose folder keeps its name, and a generator of that seed."""
    folder = target / package.name
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(package, folder)
    main = folder / "usd" / f"{package.name}.usda"
    record = json.loads((folder / "record.json").read_text())
    return Victim(folder, Usd.Stage.Open(str(main)), record, np.random.default_rng(seed))


def evidence_values(record: dict[str, Any], section: str) -> Iterator[dict[str, Any]]:
    """The values of all evidences in a list of the record."""
    for evidence in record[section]:
        yield evidence["value"]
