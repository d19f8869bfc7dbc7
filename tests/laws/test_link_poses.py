"""The links of an articulated package stand where the source puts them, at any joint positions, in every engine.

Real mechanisms are ingested; then at random positions within the limits the poses of all links agree to 0.1 mm and
0.05 degrees: of the source (`formats.link_poses`), of the USD by its joint frames alone, of PyBullet with the URDF twin
and of MuJoCo with the MJCF export.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pybullet
import pytest
from pxr import Usd, UsdGeom, UsdPhysics

from formats import link_poses, read_mjcf, read_urdf
from geom.pose import inverse, matrix_of, pose, rotation_about, to_wxyz
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from tests.support.present import present

MECHANISMS = {
    "faucet": "mjcf/libero_faucet_mjcf/faucet.xml",
    "oven": "mjcf/furniture_sim/oven.xml",  # sliding joints that follow hinges
    "robot_arm": "mjcf/dmc_robot_arm_mjcf/robot_arm.xml",  # joints that are not at zero at rest
    "fridge": "urdf/habitat_fridge_urdf/fridge.urdf",
}
STATES = 20
MOST_M, MOST_DEG = 1e-4, 0.05
AXES = {"X": np.eye(3)[0], "Y": np.eye(3)[1], "Z": np.eye(3)[2]}

Positions = Mapping[str, float]
Poses = dict[str, FloatArray]


@dataclass(frozen=True)
class Released:
    """A package, and the states at which it is compared: positions of all joints by their names in the package."""

    source: Path
    source_root: Path
    folder: Path
    record: AssetRecord
    states: tuple[dict[str, float], ...]

    @property
    def links(self) -> list[str]:
        return [link.name for link in self.record.physics.links]

    @property
    def root(self) -> str:
        return self.links[0]


@pytest.fixture(scope="module", params=list(MECHANISMS))
def package(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, shared_assets: Path) -> Released:
    source = shared_assets / MECHANISMS[request.param]
    out = tmp_path_factory.mktemp(request.param)
    command = [sys.executable, "-m", "cli.main", "assets", "ingest", str(source), "--out", str(out), "--jobs", "1"]
    subprocess.run(command, capture_output=True, timeout=100, check=False)
    item = json.loads((out / "report.json").read_text())["items"][0]
    assert item["outcome"] != "rejected", item["codes"]
    folder = out / item["packages"][0]
    record = AssetRecord.model_validate_json((folder / "record.json").read_bytes())
    rng = np.random.default_rng(7)
    joints = [joint.value for joint in record.physics.joints]
    return Released(
        source,
        shared_assets.joinpath(*Path(MECHANISMS[request.param]).parts[:2]),
        folder,
        record,
        tuple(state_of(joints, rng) for _ in range(STATES)),
    )


def state_of(joints: list[dict], rng: np.random.Generator) -> dict[str, float]:
    """Random positions within the limits; joints that follow others stand where these put them."""
    by_name = {joint["name"]: joint for joint in joints}
    free: dict[str, float] = {}

    def position(joint: dict) -> float:
        if follows := joint.get("follows"):
            return follows["multiplier"] * position(by_name[follows["joint"]]) + follows["offset"]
        lower, upper = joint.get("limits_rad") or joint.get("limits_m") or (-3.0, 3.0)
        return free.setdefault(joint["name"], float(rng.uniform(lower, upper)))

    return {joint["name"]: position(joint) for joint in joints}


def relative(X_WL: Poses, root: str) -> Poses:
    """Poses in the frame of the root link."""
    return {name: inverse(X_WL[root]) @ X for name, X in X_WL.items()}


def from_source(package: Released) -> Callable[[Positions], Poses]:
    """What a link moved by since rest, as the source has it, applied to its pose at rest in the package."""
    read_description = read_urdf if package.source.suffix == ".urdf" else read_mjcf
    description = read_description(package.source, package.source_root)
    geometry, physics = package.record.geometry, package.record.physics
    X_AM = pose(matrix_of(np.array(geometry.source_quat_wxyz)), geometry.origin_offset_m)
    joints = [joint.value for joint in physics.joints]
    sources = {joint["name"]: joint.get("source_name", joint["name"]) for joint in joints}
    at_rest = link_poses(
        description, {sources[j["name"]]: float(j.get("rest_rad", j.get("rest_m", 0.0))) for j in joints}
    )

    def poses(state: Positions) -> Poses:
        now = link_poses(description, {sources[name]: position for name, position in state.items()})
        X_WL: Poses = {}
        for link in physics.links:
            member = link.members[0]
            moved_M = now[member] @ inverse(at_rest[member])
            X_WL[link.name] = X_AM @ moved_M @ inverse(X_AM) @ pose(None, link.origin_m)
        return X_WL

    return poses


class UsdJoint(NamedTuple):
    """A joint as UsdPhysics has it: its frame in either body, and its axis in that frame."""

    name: str
    parent: str
    child: str
    X_PJ: FloatArray
    X_CJ: FloatArray
    axis: FloatArray
    slides: bool


def from_usd(package: Released) -> Callable[[Positions], Poses]:
    """By the frames and axes of UsdPhysics joints alone, in degrees as the file has them."""
    stage = Usd.Stage.Open(str(next((package.folder / "usd").glob("*.usda"))))
    rest = {
        name: np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetDefaultPrim().GetChild(name))).T
        for name in package.links
    }

    def frame(prim: Usd.Prim, side: int) -> FloatArray:
        quat = prim.GetAttribute(f"physics:localRot{side}").Get()
        position = np.array(prim.GetAttribute(f"physics:localPos{side}").Get(), dtype=np.float64)
        return pose(matrix_of(np.array([quat.GetReal(), *quat.GetImaginary()])), position)

    joints = [
        UsdJoint(
            prim.GetName(),
            prim.GetRelationship("physics:body0").GetTargets()[0].name,
            prim.GetRelationship("physics:body1").GetTargets()[0].name,
            frame(prim, 0),
            frame(prim, 1),
            AXES[prim.GetAttribute("physics:axis").Get()],
            prim.IsA(UsdPhysics.PrismaticJoint),
        )
        for prim in stage.Traverse()
        if prim.IsA(UsdPhysics.Joint)
    ]

    def poses(state: Positions) -> Poses:
        X_WL = {package.root: rest[package.root]}
        waiting = list(joints)
        while waiting:
            joint = waiting.pop(0)
            if joint.parent not in X_WL:
                waiting.append(joint)
                continue
            q = state[joint.name]
            moved = pose(None, q * joint.axis) if joint.slides else pose(rotation_about(joint.axis, q))
            X_WL[joint.child] = X_WL[joint.parent] @ joint.X_PJ @ moved @ inverse(joint.X_CJ)
        return X_WL

    return poses


def from_bullet(package: Released) -> Callable[[Positions], Poses]:
    client = pybullet.connect(pybullet.DIRECT)
    twin = next((package.folder / "export").glob("*.urdf"))
    body = pybullet.loadURDF(
        str(twin), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client
    )
    infos = [pybullet.getJointInfo(body, i, client) for i in range(pybullet.getNumJoints(body, client))]
    numbers = {info[1].decode(): info[0] for info in infos}
    children = {info[12].decode(): info[0] for info in infos}
    base = pybullet.getDynamicsInfo(body, -1, client)

    def poses(state: Positions) -> Poses:
        for name, position in state.items():
            pybullet.resetJointState(body, numbers[name], position, physicsClientId=client)
        at, quat = pybullet.getBasePositionAndOrientation(body, client)
        X_WI = pose(matrix_of(to_wxyz(np.array(quat))), np.array(at))
        X_LI = pose(matrix_of(to_wxyz(np.array(base[4]))), np.array(base[3]))
        X_WL = {package.root: X_WI @ inverse(X_LI)}
        for name, number in children.items():
            link = pybullet.getLinkState(body, number, computeForwardKinematics=True, physicsClientId=client)
            X_WL[name] = pose(matrix_of(to_wxyz(np.array(link[5]))), np.array(link[4]))
        return X_WL

    return poses


def from_mujoco(package: Released) -> Callable[[Positions], Poses]:
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    data = mujoco.MjData(model)

    def poses(state: Positions) -> Poses:
        for name, position in state.items():
            data.qpos[model.joint(name).qposadr[0]] = position
        mujoco.mj_kinematics(model, data)
        return {name: pose(matrix_of(data.body(name).xquat), data.body(name).xpos) for name in package.links}

    return poses


@pytest.mark.parametrize("judge", [from_usd, from_bullet, from_mujoco], ids=["usd", "pybullet", "mujoco"])
def test_links_stand_where_the_source_has_them(package: Released, judge: Callable) -> None:
    expected, judged = from_source(package), judge(package)
    for state in package.states:
        right, engine = relative(expected(state), package.root), relative(judged(state), package.root)
        assert set(engine) == set(package.links)
        for name, X in right.items():
            error = inverse(X) @ engine[name]
            turn_deg = np.degrees(np.arccos(np.clip((np.trace(error[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
            assert np.linalg.norm(error[:3, 3]) < MOST_M, (name, state)
            assert turn_deg < MOST_DEG, (name, state)


def test_engines_weigh_the_links_alike(package: Released) -> None:
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    for link in package.record.physics.links:
        assert model.body(link.name).mass[0] == pytest.approx(link.mass_kg.value, rel=1e-5)
        centre = np.array(link.centre_of_mass_m.value) - np.array(link.origin_m)
        assert model.body(link.name).ipos == pytest.approx(centre, abs=1e-6)


def test_limits_are_those_of_the_record(package: Released) -> None:
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    for joint in (evidence.value for evidence in package.record.physics.joints):
        limits = joint.get("limits_rad") or joint.get("limits_m")
        in_engine = model.joint(joint["name"])
        assert bool(model.jnt_limited[in_engine.id]) == (limits is not None)
        if limits is not None:
            assert in_engine.range == pytest.approx(limits, abs=1e-6)
        assert in_engine.axis == pytest.approx(present(joint["axis"]), abs=1e-6)
