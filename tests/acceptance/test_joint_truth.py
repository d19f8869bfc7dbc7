"""Joints of the shared mechanisms against two truths that share no code with Mana.

`joints.json` beside the dev manifest lists names, types, limits and axes as the files state them; where an axis points
in the object is found here by MuJoCo, by plain forward kinematics of the URDF, or from the transforms of the stage.
`tests/data/joints/by_eye.csv` was written from pictures of every joint, before anything was compared.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics
from scipy.spatial.transform import Rotation

from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.readers.by_format import READERS
from assetkit.sources.source_file import SourceFile
from assetkit.stage import Intake
from schemas.mechanism import Mechanism
from schemas.model import Model
from tests.conftest import SHARED
from tests.support.present import present

ROOT = Path(__file__).parents[2]
ASSETS = SHARED / "assets"
BY_EYE = ROOT / "tests" / "data" / "joints" / "by_eye.csv"
LEAST_AGREEMENT = 0.95
MOST_AXIS_DEG, MOST_LIMIT = 1.0, 1e-3
WORDS = {"hinge": "revolute", "slide": "prismatic", "continuous": "revolute"}
# Joints between the world and the object are no joints of the object.
TO_WORLD = {
    "pb_half_cheetah_mjcf": {"ignorex", "ignorez", "ignorey"},
    "gen_mjcf_degrees": {"h"},
}

pytestmark = pytest.mark.shared


@dataclass(frozen=True)
class TrueJoint:
    """A joint as the list states it; `limits` in rad or m, None without."""

    name: str
    kind: str
    limits: tuple[float, float] | None


@cache
def rows() -> dict[str, dict[str, str]]:
    with (ASSETS / "manifest.csv").open() as file:
        return {row["id"]: row for row in csv.DictReader(file)}


@cache
def truth() -> dict[str, tuple[TrueJoint, ...]]:
    listed = json.loads((ASSETS / "joints.json").read_text())
    accepted = {k: v for k, v in listed.items() if rows()[k]["outcome"] != "reject" and rows()[k]["split"] == "dev"}
    return {name: tuple(_true_joints(entry)) for name, entry in accepted.items()}


def _true_joints(entry: str | list[dict]) -> Iterator[TrueJoint]:
    if isinstance(entry, str):
        for row in entry.split("|"):
            parts = row.strip().split(":")
            span = re.findall(r"-?[\d.]*\d", parts[2].replace("..", " ")) if len(parts) > 2 else []
            limits = (float(span[0]), float(span[1])) if span else None
            yield TrueJoint(parts[0], parts[1].split()[0], limits)
        return
    for row in entry:
        kind = row["type"].removeprefix("Physics").removesuffix("Joint").lower()
        stated = row.get("range") or [row.get("lower"), row.get("upper")]
        if "lowerLimit" in row:
            stated = [row["lowerLimit"], row["upperLimit"]]
            stated = np.radians(stated).tolist() if kind == "revolute" else stated
        numbers = [float(v) for v in stated if v is not None and math.isfinite(float(v))]
        limits = (numbers[0], numbers[1]) if len(numbers) == 2 and kind != "continuous" else None
        if kind != "fixed":
            yield TrueJoint(row["name"], WORDS.get(kind, kind), limits)


def path_of(name: str) -> tuple[Path, Path]:
    """The file of a row and the root of its asset."""
    relative = Path(rows()[name]["path"])
    return ASSETS / relative, ASSETS.joinpath(*relative.parts[: 3 if "malformed" in relative.parts else 2])


@cache
def model_of(name: str) -> Model:
    path, root = path_of(name)
    return present(READERS[rows()[name]["format"]](SourceFile(path, root)).value).with_mesh_ids()


def axes_in_object(name: str, mechanism: Mechanism | None) -> dict[str, np.ndarray]:
    """Unit axes of the joints in the object at its rest state, by another way than Mana's; {} where none reads it."""
    path, _ = path_of(name)
    joints = () if mechanism is None else mechanism.joints
    if rows()[name]["format"] == "usd":
        return _axes_of_stage(path, {joint.source_name: joint.child for joint in joints})
    rest = {joint.source_name: joint.rest for joint in joints}
    return _axes_by_mujoco(path, rest) if rows()[name]["format"] == "mjcf" else _axes_of_urdf(path, rest)


def _axes_by_mujoco(path: Path, rest: dict[str, float]) -> dict[str, np.ndarray]:
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:  # MuJoCo refuses some of these files, which is why they are there
        return {}
    data = mujoco.MjData(model)
    for name, position in rest.items():
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
        if index >= 0:
            data.qpos[model.jnt_qposadr[index]] = position
    mujoco.mj_kinematics(model, data)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, i) or "" for i in range(model.njnt)]
    return {n: np.array(data.xaxis[i]) for i, n in enumerate(names) if n}


def _axes_of_urdf(path: Path, rest: dict[str, float]) -> dict[str, np.ndarray]:
    joints = {}
    for joint in ElementTree.parse(path).getroot().iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            joints[child.get("link")] = (joint, parent.get("link"))

    def numbers(joint: ElementTree.Element, tag: str, key: str, default: str) -> np.ndarray:
        element = joint.find(tag)
        return np.array([float(v) for v in (default if element is None else element.get(key, default)).split()])

    def rotation_to(link: str | None) -> Rotation:
        """Of the link after its joint has moved to rest."""
        if link not in joints:
            return Rotation.identity()
        joint, parent = joints[link]
        frame = rotation_to(parent) * Rotation.from_euler("xyz", numbers(joint, "origin", "rpy", "0 0 0"))
        turns = joint.get("type") in ("revolute", "continuous")
        axis = numbers(joint, "axis", "xyz", "1 0 0")
        return frame * Rotation.from_rotvec(axis * rest.get(joint.get("name", ""), 0.0)) if turns else frame

    axes = {}
    for link, (joint, _) in joints.items():
        axis = rotation_to(link).apply(numbers(joint, "axis", "xyz", "1 0 0"))
        axes[joint.get("name", "")] = axis / np.linalg.norm(axis)
    return axes


def _axes_of_stage(path: Path, children: dict[str, str]) -> dict[str, np.ndarray]:
    """Of the stage as authored, in which joints are at rest. An axis turns the second body against the first one; where
    the first one is the child, the joint is written from child to parent.
    """
    stage = Usd.Stage.Open(str(path))
    cache_ = UsdGeom.XformCache()
    axes = {}
    for prim in stage.Traverse():
        joint = (
            UsdPhysics.RevoluteJoint(prim) if prim.IsA(UsdPhysics.RevoluteJoint) else UsdPhysics.PrismaticJoint(prim)
        )
        if not joint:
            continue
        unit = {"X": Gf.Vec3d(1, 0, 0), "Y": Gf.Vec3d(0, 1, 0), "Z": Gf.Vec3d(0, 0, 1)}[joint.GetAxisAttr().Get()]
        bodies = UsdPhysics.Joint(prim).GetBody0Rel().GetTargets()
        turned = Gf.Rotation(joint.GetLocalRot0Attr().Get()).TransformDir(unit)
        world = cache_.GetLocalToWorldTransform(stage.GetPrimAtPath(bodies[0])) if bodies else Gf.Matrix4d(1.0)
        axis = np.array(world.ExtractRotation().TransformDir(turned))
        from_child = bool(bodies) and bodies[0].name == children.get(prim.GetName())
        axes[prim.GetName()] = (-axis if from_child else axis) / np.linalg.norm(axis)
    return axes


def test_joint_counts_types_axes_and_limits_agree_with_the_list() -> None:
    """Of a joint all of these must agree, or it is a miss."""
    count, misses, no_axis = 0, list[str](), list[str]()
    for name, joints in truth().items():
        mechanism = model_of(name).mechanism
        ours = {joint.source_name: joint for joint in mechanism.joints} if mechanism is not None else {}
        extra = ours.keys() - {joint.name for joint in joints}
        misses += [f"{name}/{joint}: not in the list" for joint in sorted(extra)]
        axes = axes_in_object(name, mechanism)
        for joint in joints:
            count += 1
            mine = ours.get(joint.name)
            if mine is None:
                misses.append(f"{name}/{joint.name}: absent")
                continue
            if WORDS.get(mine.kind, mine.kind) != joint.kind:
                misses.append(f"{name}/{joint.name}: {mine.kind}, not {joint.kind}")
            stated = None if mine.limits_inferred else mine.limits
            same = (stated is None) == (joint.limits is None)
            if not same or (stated is not None and not np.allclose(stated, joint.limits or (), atol=MOST_LIMIT)):
                misses.append(f"{name}/{joint.name}: limits {stated}, not {joint.limits}")
            if joint.name not in axes:
                no_axis.append(f"{name}/{joint.name}")
                continue
            cosine = float(np.clip(mine.axis @ axes[joint.name], -1.0, 1.0))
            if math.degrees(math.acos(cosine)) > MOST_AXIS_DEG:
                misses.append(f"{name}/{joint.name}: axis {mine.axis}, not {axes[joint.name]}")
    agreement = 1.0 - len({miss.split(":")[0] for miss in misses}) / count
    print(f"\n{count} joints, agreement {agreement:.3f}; misses: {misses}; axes without another reader: {no_axis}")
    assert agreement >= LEAST_AGREEMENT, misses
    expected = {f"{name}/{joint}: absent" for name, joints in TO_WORLD.items() for joint in joints}
    assert set(misses) == expected, "all misses are joints to the world"
    assert len(no_axis) <= 0.15 * count, no_axis


@pytest.mark.long
def test_groups_and_opening_agree_with_the_table_by_eye() -> None:
    """Groups: never a sure one against the eye. The table has every joint that moves on its own."""
    with BY_EYE.open() as file:
        table = {(row["asset"], row["joint"]): row for row in csv.DictReader(file)}
    seen, wrong_groups, wrong_ways, missed = set(), list[str](), list[str](), list[str]()
    for name in sorted(truth()):
        model = model_of(name)
        if model.mechanism is None:
            continue
        extent = np.ptp(np.concatenate([mesh.points for mesh in model.meshes]), axis=0)
        item = Intake(rows()[name]["format"], (), model, tuple(extent))
        canonical = present(canonicalize(item, path_of(name)[0].name, Options()).value)
        mechanism = present(canonical.mechanism)
        sources = {joint.name: joint.source_name for joint in mechanism.joints}
        for use in joint_uses(ArticulatedObject(mechanism, canonical.links, canonical.meshes)):
            key = (name, sources[use.joint])
            seen.add(key)
            eye = table[key]
            way = "none" if use.open.confidence == 0.0 else "+" if use.sense > 0 else "-"
            seen_by_eye = f"by eye {eye['group']} {eye['opening']}"
            line = f"{name}/{key[1]}: {use.group.value} {use.group.confidence} {way}, {seen_by_eye}"
            if use.group.value == "unknown" != eye["group"]:
                missed.append(line)
            elif use.group.value != eye["group"]:
                wrong_groups.append(line)
            if way not in ("none", eye["opening"]):
                wrong_ways.append(line)
    count = len(seen)
    print(f"\n{count} joints; groups missed: {missed}; wrong groups: {wrong_groups}; wrong ways: {wrong_ways}")
    assert seen == set(table)
    assert 1.0 - (len(missed) + len(wrong_groups)) / count >= 0.9
    assert 1.0 - len(wrong_ways) / count >= LEAST_AGREEMENT
    assert all(float(line.split()[2]) < 0.5 for line in wrong_groups), "what the eye refutes is never sure"
