"""The links of an articulated package stand where the source puts them, at any joint positions, in every engine.

Real mechanisms are ingested; then at random positions within the limits the poses of all links agree to 0.1 mm and
0.05 degrees: of the source (`formats.link_poses`, or the joint frames of a stage alone), of the USD by its joint frames
alone, of PyBullet with the URDF twin and of MuJoCo with the MJCF export. All three have the joints, limits and masses
of the record.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pybullet
import pytest
from pxr import Usd, UsdPhysics

from formats import link_poses, read_mjcf, read_urdf
from geom.pose import inverse, matrix_of, pose, to_wxyz
from schemas.asset import AssetRecord
from tests.support.mechanism import mujoco_usd_links
from tests.support.mechanism.stage_poses import Poses, Positions, moving_joints, stage_poses
from tests.support.peers import answer_of
from tests.support.present import present

MECHANISMS = {
    "faucet": "mjcf/libero_faucet_mjcf/faucet.xml",
    "oven": "mjcf/furniture_sim/oven.xml",  # sliding joints that follow hinges
    "robot_arm": "mjcf/dmc_robot_arm_mjcf/robot_arm.xml",  # joints that are not at zero at rest
    "fridge": "urdf/habitat_fridge_urdf/fridge.urdf",
    "cartpole": "usd/nwt_cartpole_usda/cartpole.usda",  # scaled bodies, joints without limits
    "fourbar": "usd/nwt_fourbar_usda/boxes_fourbar.usda",  # a loop, a joint from child to parent
}
STATES = 20
MOST_M, MOST_DEG = 1e-4, 0.05

ANSWERS: dict[Path, dict] = {}  # of the USD-native loader, by package


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
    def joints(self) -> list[dict]:
        """The joints of the tree, as the record has them."""
        return [joint for joint in joints_on(self.record) if not joint.get("closes_loop")]

    @property
    def root(self) -> str:
        return self.links[0]


def joints_on(record: AssetRecord) -> list[dict]:
    return [joint.value for joint in record.physics.joints]


LONG = ("faucet", "fridge")  # in `make test-long`: the others have all that these have
PACKAGES = [pytest.param(name, marks=pytest.mark.long if name in LONG else ()) for name in MECHANISMS]


@pytest.fixture(scope="module", params=PACKAGES)
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
    joints = [joint for joint in joints_on(record) if not joint.get("closes_loop")]
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
    posed = source_poses(package)
    geometry, physics = package.record.geometry, package.record.physics
    X_AM = pose(matrix_of(np.array(geometry.source_quat_wxyz)), geometry.origin_offset_m)
    joints = package.joints
    sources = {joint["name"]: joint.get("source_name", joint["name"]) for joint in joints}
    at_rest = posed({sources[j["name"]]: float(j.get("rest_rad", j.get("rest_m", 0.0))) for j in joints})

    def poses(state: Positions) -> Poses:
        now = posed({sources[name]: position for name, position in state.items()})
        X_WL: Poses = {}
        for link in physics.links:
            member = next(name for name in link.members if name in now)
            moved_M = now[member] @ inverse(at_rest[member])
            X_WL[link.name] = X_AM @ moved_M @ inverse(X_AM) @ pose(None, link.origin_m)
        return X_WL

    return poses


def source_poses(package: Released) -> Callable[[Positions], Poses]:
    """Poses of the links of the source, by their names there, at positions of its joints."""
    if package.source.suffix == ".usda":
        return stage_poses(package.source, package.record.physics.links[0].members[-1])
    read_description = read_urdf if package.source.suffix == ".urdf" else read_mjcf
    description = read_description(package.source, package.source_root)
    return lambda positions: link_poses(description, positions)


def main_usd(package: Released) -> Path:
    return next((package.folder / "usd").glob("*.usda"))


def from_usd(package: Released) -> Callable[[Positions], Poses]:
    return stage_poses(main_usd(package), package.root)


class BulletTwin(NamedTuple):
    """The URDF twin in PyBullet; `joints` are PyBullet's rows of `getJointInfo`."""

    client: int
    body: int
    joints: list[tuple]


def in_bullet(package: Released) -> BulletTwin:
    """With a free base: of a fixed one PyBullet gives no mass."""
    client = pybullet.connect(pybullet.DIRECT)
    twin = next((package.folder / "export").glob("*.urdf"))
    body = pybullet.loadURDF(str(twin), flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client)
    joints = [pybullet.getJointInfo(body, i, client) for i in range(pybullet.getNumJoints(body, client))]
    return BulletTwin(client, body, joints)


def from_bullet(package: Released) -> Callable[[Positions], Poses]:
    client, body, infos = in_bullet(package)
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
        engine = relative(judged(state), package.root)
        assert set(engine) == set(package.links)
        require_equal_poses(relative(expected(state), package.root), engine, state)


def require_equal_poses(expected: Poses, judged: Poses, state: Positions) -> None:
    for name, X in expected.items():
        error = inverse(X) @ judged[name]
        turn_deg = np.degrees(np.arccos(np.clip((np.trace(error[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
        assert np.linalg.norm(error[:3, 3]) < MOST_M, (name, state)
        assert turn_deg < MOST_DEG, (name, state)


def test_outside_validators_and_the_gate_pass_the_package(package: Released) -> None:
    checks = {check.name: check.passed for check in present(package.record.acceptance).validators}
    assert checks == dict.fromkeys(("simready", "usd-validation", "mana gate"), True)


def test_engines_weigh_the_links_alike(package: Released) -> None:
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    for link in package.record.physics.links:
        assert model.body(link.name).mass[0] == pytest.approx(link.mass_kg.value, rel=1e-5)
        centre = np.array(link.centre_of_mass_m.value) - np.array(link.origin_m)
        assert model.body(link.name).ipos == pytest.approx(centre, abs=1e-6)


def test_limits_are_those_of_the_record(package: Released) -> None:
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    assert model.njnt == len(package.joints)
    for joint in package.joints:
        limits = joint.get("limits_rad") or joint.get("limits_m")
        in_engine = model.joint(joint["name"])
        assert bool(model.jnt_limited[in_engine.id]) == (limits is not None)
        if limits is not None:
            assert in_engine.range == pytest.approx(limits, abs=1e-6)
        assert in_engine.axis == pytest.approx(present(joint["axis"]), abs=1e-6)


Limits = tuple[float, float] | None


def numbers_in_usd(package: Released) -> tuple[dict[str, float], dict[str, Limits]]:
    """Masses of links (kg) and limits of joints (rad, m) by name."""
    stage = Usd.Stage.Open(str(main_usd(package)))
    masses = {p.GetName(): UsdPhysics.MassAPI(p) for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    limits: dict[str, Limits] = {}
    for prim in moving_joints(stage):
        span = np.array([prim.GetAttribute(f"physics:{end}Limit").Get() for end in ("lower", "upper")])
        lower, upper = span if prim.IsA(UsdPhysics.PrismaticJoint) else np.radians(span)
        limits[prim.GetName()] = (lower, upper) if np.isfinite(span).all() else None
    return {name: api.GetMassAttr().Get() for name, api in masses.items()}, limits


def numbers_in_bullet(package: Released) -> tuple[dict[str, float], dict[str, Limits]]:
    """As `numbers_in_usd`; a joint that turns without end has a lower limit above the upper one in PyBullet."""
    client, body, joints = in_bullet(package)
    links = {package.root: -1} | {joint[12].decode(): joint[0] for joint in joints}
    masses = {name: pybullet.getDynamicsInfo(body, index, client)[0] for name, index in links.items()}
    limits = {joint[1].decode(): (joint[8], joint[9]) if joint[8] <= joint[9] else None for joint in joints}
    return masses, limits


@pytest.mark.parametrize("judge", [numbers_in_usd, numbers_in_bullet], ids=["usd", "pybullet"])
def test_usd_and_pybullet_have_the_joints_limits_and_masses_of_the_record(package: Released, judge: Callable) -> None:
    masses, limits = judge(package)
    physics = package.record.physics
    assert masses == pytest.approx({link.name: link.mass_kg.value for link in physics.links}, rel=1e-5)
    joints = {joint["name"]: joint for joint in package.joints}
    assert limits.keys() == joints.keys()
    for name, joint in joints.items():
        stated = joint.get("limits_rad") or joint.get("limits_m")
        assert limits[name] == (None if stated is None else pytest.approx(stated, abs=1e-5)), name


def native_answer(package: Released) -> dict:
    """What MuJoCo's USD reader holds of the package (`tests.support.mechanism.mujoco_usd_links`), posed in all states.

    It counts positions from the pose of the stage, wherever that is within the limits, so rest positions are taken off.
    """
    if package.folder in ANSWERS:
        return ANSWERS[package.folder]
    rest = {joint["name"]: joint.get("rest_rad", joint.get("rest_m", 0.0)) for joint in package.joints}
    states = [{name: position - rest[name] for name, position in state.items()} for state in package.states]
    request = {"file": str(main_usd(package)), "states": states}
    ANSWERS[package.folder] = answer_of("mujoco-usd", mujoco_usd_links.__file__, request, timeout_s=100)
    return ANSWERS[package.folder]


def test_a_usd_native_loader_has_the_joints_axes_limits_and_masses_of_the_record(package: Released) -> None:
    answer = native_answer(package)
    assert answer["masses_kg"] == pytest.approx(
        {link.name: link.mass_kg.value for link in package.record.physics.links}, rel=1e-5
    )
    assert answer["joints"].keys() == {joint["name"] for joint in package.joints}
    for joint in package.joints:
        read, stated = answer["joints"][joint["name"]], joint.get("limits_rad") or joint.get("limits_m")
        assert (read["child"], read["slides"]) == (joint["child"], joint["type"] == "prismatic")
        assert read["axis"] == pytest.approx(present(joint["axis"]), abs=1e-6)
        assert read["limits"] == (None if stated is None else pytest.approx(stated, abs=1e-5)), joint["name"]


def test_links_stand_where_the_source_has_them_in_a_usd_native_loader(package: Released) -> None:
    expected = from_source(package)
    for state, poses in zip(package.states, native_answer(package)["poses"], strict=True):
        read = {name: pose(matrix_of(np.array(numbers[3:])), np.array(numbers[:3])) for name, numbers in poses.items()}
        require_equal_poses(relative(expected(state), package.root), relative(read, package.root), state)


def test_loops_stay_closed_in_mujoco(package: Released) -> None:
    """A tenth of a second under gravity: the equalities of closing joints hold to a millimetre."""
    model = mujoco.MjModel.from_xml_path(str(next((package.folder / "export").glob("*.xml"))))
    closing = [joint for joint in joints_on(package.record) if joint.get("closes_loop")]
    connects = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_CONNECT]
    assert len(connects) == sum({"prismatic": 0, "ball": 1}.get(joint["type"], 2) for joint in closing)
    data = mujoco.MjData(model)
    for joint in package.joints:
        data.qpos[model.joint(joint["name"]).qposadr[0]] = joint.get("rest_rad", joint.get("rest_m", 0.0))
    mujoco.mj_step(model, data, nstep=round(0.1 / model.opt.timestep))
    for i in connects:
        first, second = data.site_xpos[model.eq_obj1id[i]], data.site_xpos[model.eq_obj2id[i]]
        assert np.linalg.norm(first - second) < 1e-3


def test_joints_that_close_loops_are_outside_the_articulation(package: Released) -> None:
    stage = Usd.Stage.Open(str(main_usd(package)))
    joints = {p.GetName(): UsdPhysics.Joint(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Joint)}
    excluded = {name: bool(joint.GetExcludeFromArticulationAttr().Get()) for name, joint in joints.items()}
    assert excluded == {j["name"]: j.get("closes_loop", False) for j in joints_on(package.record)}
    assert any(excluded.values()) == (package.source.stem == "boxes_fourbar")
