"""Descriptions against MuJoCo and PyBullet, which load the same files: joints, axes, limits, link poses, masses.

Files: everything that pybullet_data and the shared data bring. A file that an engine refuses is no case for it.
"""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pybullet
import pybullet_data
import pytest
import trimesh

from formats import link_mass, link_poses, read_mjcf, read_urdf
from formats.mesh_points import in_shape_frame
from geom.mass.inertia import enclosed_volume, is_physical
from geom.pose import inverse, matrix_of, pose, to_wxyz
from schemas.diagnostics import InvalidInput
from schemas.physics import VolumeProperties
from schemas.robot_description import DescribedJoint, MeshReference, RobotDescription
from tests.conftest import SHARED
from tests.support.present import present

BULLET = Path(pybullet_data.getDataPath())
ASSETS = SHARED / "assets"
NUMERALS = "random_urdfs"  # a thousand files of one link and one mesh; a few stand for all
STATES = 5

# What we refuse, with the code; the other files are read.
REFUSED = {
    "biped/biped2d_pybullet.urdf": "robot/unreadable",
    "differential/diff_ring.urdf": "robot/unreadable",
    "humanoid/humanoid.urdf": "robot/unreadable",
    "husky/husky.urdf": "robot/xacro",
    "mjcf/hopper.xml": "robot/global-coordinates",
    "mjcf/humanoid_fixed.xml": "robot/invalid-value",
    "mjcf/walker2d.xml": "robot/global-coordinates",
    "quadruped/microtaur/microtaur.urdf": "robot/invalid-number",
    "racecar/racecar_differential.urdf": "robot/invalid-number",
    "torus_deform.urdf": "robot/no-links",
}
CABINET = "mjcf/libero_wooden_cabinet_mjcf/wooden_cabinet"
# What we read and the engine refuses, with its words; there is nothing to compare with.
REFUSED_BY_ENGINE = {
    "kuka_iiwa/model_for_sdf.urdf": "Cannot load URDF file",
    "toys/concave_box.urdf": "Cannot load URDF file",
    "urdf/habitat_fridge_urdf/fridge.urdf": "Cannot load URDF file",
    "urdf/ycb_001_chips_can_urdf_missingmesh/model.urdf": "Cannot load URDF file",
    "mjcf/ground.xml": "joint 'left_hip_y' not found",
    "mjcf/ground_plane.xml": "plane size",
    "mjcf/half_cheetah.xml": "required attribute missing: 'pos'",
    "mjcf/humanoid_symmetric.xml": "material 'geom' not found",
    "mjcf/swimmer.xml": "unrecognized attribute: 'collision'",
    "mjcf/libero_faucet_mjcf/faucet.xml": "mass and inertia of moving bodies",
    "mjcf/libero_flat_stove_mjcf/flat_stove.xml": "repeated name 'tex-stove_knob'",
    "mjcf/libero_microwave_mjcf/microwave.xml": "mass and inertia of moving bodies",
    f"{CABINET}/wooden_cabinet_base/wooden_cabinet_base.xml": "unsupported content type",
    "mjcf/pb_half_cheetah_mjcf/half_cheetah.xml": "required attribute missing: 'pos'",
}


def urdf_files() -> list[Path]:
    files = [p for p in sorted(BULLET.rglob("*.urdf")) if NUMERALS not in p.parts or p.stem in ("000", "472")]
    return files + sorted((ASSETS / "urdf").rglob("*.urdf"))


def mjcf_files() -> list[Path]:
    files = [*sorted((BULLET / "mjcf").rglob("*.xml")), *sorted((ASSETS / "mjcf").rglob("*.xml"))]
    return [p for p in files if b"<mujoco" in p.read_bytes()[:20_000] and b"<mujocoinclude" not in p.read_bytes()]


def root_of(path: Path) -> Path:
    """The folder that a file's references may not leave: that of its asset, or of all of pybullet_data."""
    if path.is_relative_to(BULLET):
        return BULLET
    return ASSETS / path.relative_to(ASSETS).parts[0] / path.relative_to(ASSETS).parts[1]


def name_of(path: Path) -> str:
    return str(path.relative_to(BULLET if path.is_relative_to(BULLET) else ASSETS))


def described(path: Path) -> RobotDescription | None:
    """What we read; None for a file that we refuse with the code of the table."""
    read = read_urdf if path.suffix == ".urdf" else read_mjcf
    if (code := REFUSED.get(name_of(path))) is None:
        return read(path, root_of(path))
    with pytest.raises(InvalidInput) as refusal:
        read(path, root_of(path))
    assert refusal.value.diagnostic.code == code
    return None


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """PyBullet prints from C."""
    with tempfile.TemporaryFile() as sink:
        saved = os.dup(1), os.dup(2)
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved[0], 1)
            os.dup2(saved[1], 2)
            os.close(saved[0])
            os.close(saved[1])


def positions(joint: DescribedJoint, rng: np.random.Generator) -> float | np.ndarray:
    """A random position within the limits of a joint."""
    if joint.kind == "ball":
        quat = rng.normal(size=4)
        return quat / np.linalg.norm(quat)
    lower, upper = joint.limits if joint.limits and joint.limits.lower < joint.limits.upper else (-1.0, 1.0)
    return float(rng.uniform(max(lower, -3.0), min(upper, 3.0)))


@pytest.mark.parametrize("path", urdf_files(), ids=name_of)
def test_urdf_is_read_as_pybullet_reads_it(path: Path) -> None:
    if (ours := described(path)) is None:
        return
    client = pybullet.connect(pybullet.DIRECT)
    try:
        with refused_by_engine(path, pybullet.error), quiet():
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
        if name_of(path) not in REFUSED_BY_ENGINE:
            check_against_bullet(ours, body, client)
    finally:
        pybullet.disconnect(client)


def refused_by_engine(path: Path, error: type[Exception]) -> contextlib.AbstractContextManager[object]:
    """The engine refuses a file of the table, in its words, and no other."""
    words = REFUSED_BY_ENGINE.get(name_of(path))
    return contextlib.nullcontext() if words is None else pytest.raises(error, match=re.escape(words))


def check_against_bullet(ours: RobotDescription, body: int, client: int) -> None:
    """Count, names, types, axes, limits and dynamics of all joints; link poses at random states; masses."""
    infos = [pybullet.getJointInfo(body, j, client) for j in range(pybullet.getNumJoints(body, client))]
    theirs = {info[1].decode(): info for info in infos}
    by_name = {joint.name: joint for joint in ours.joints}
    assert set(theirs) == set(by_name)
    kinds = {"revolute": 0, "continuous": 0, "prismatic": 1, "ball": 2, "planar": 3, "fixed": 4}
    for number, info in enumerate(infos):
        joint = by_name[info[1].decode()]
        R_LI = matrix_of(to_wxyz(np.array(pybullet.getDynamicsInfo(body, number, client)[4])))
        if joint.kind in kinds:
            assert info[2] == kinds[joint.kind]
        assert info[12].decode() == joint.child
        if joint.kind in ("revolute", "prismatic", "continuous"):
            np.testing.assert_allclose(R_LI @ info[13], joint.axis_C, atol=1e-6)  # given in the inertial frame
            assert info[6] == pytest.approx(joint.damping)
            assert info[7] == pytest.approx(joint.friction)
        if joint.limits is not None:
            assert (info[8], info[9]) == pytest.approx(tuple(joint.limits))
            assert info[10] == pytest.approx(joint.effort or 0.0)
            assert info[11] == pytest.approx(joint.velocity or 0.0)
    rng = np.random.default_rng(0)
    for _ in range(STATES):
        state = {}
        for number, info in enumerate(infos):
            joint = by_name[info[1].decode()]
            if joint.kind in ("revolute", "continuous", "prismatic"):
                state[joint.name] = positions(joint, rng)
                pybullet.resetJointState(body, number, state[joint.name], physicsClientId=client)
        X_RL = link_poses(ours, state)
        X_WI = bullet_pose(*pybullet.getBasePositionAndOrientation(body, client))
        X_RW = bullet_pose(*pybullet.getDynamicsInfo(body, -1, client)[3:5]) @ inverse(X_WI)
        for number, info in enumerate(infos):
            link = pybullet.getLinkState(body, number, computeForwardKinematics=True, physicsClientId=client)
            np.testing.assert_allclose(
                X_RW @ bullet_pose(link[4], link[5]), X_RL[by_name[info[1].decode()].child], atol=2e-5
            )
    links = {link.name: link for link in ours.links}
    for number, info in enumerate(infos):
        link = links[by_name[info[1].decode()].child]
        if link.inertial is not None and link.inertial.mass_kg > 0.0:
            dynamics = pybullet.getDynamicsInfo(body, number, client)
            assert dynamics[0] == pytest.approx(link.inertial.mass_kg)
            tensor = link.inertial.inertia_kgm2
            if tensor is not None and is_physical(tensor) and not tensor[~np.eye(3, dtype=bool)].any():
                np.testing.assert_allclose(sorted(dynamics[2]), np.linalg.eigvalsh(tensor), rtol=1e-5)


def bullet_pose(position: tuple[float, ...], quat_xyzw: tuple[float, ...]) -> np.ndarray:
    return pose(matrix_of(to_wxyz(np.array(quat_xyzw))), np.array(position))


@pytest.mark.parametrize("path", mjcf_files(), ids=name_of)
def test_mjcf_is_read_as_mujoco_reads_it(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log there.
    if (ours := described(path)) is None:
        return
    with warnings.catch_warnings(), refused_by_engine(path, ValueError):
        warnings.simplefilter("ignore")
        model = mujoco.MjModel.from_xml_path(str(path))
    if name_of(path) not in REFUSED_BY_ENGINE:
        check_against_mujoco(ours, model, root_of(path))


def check_against_mujoco(ours: RobotDescription, model: mujoco.MjModel, root: Path) -> None:
    """Bodies and joints in their order, axes, limits, dynamics, body poses, geoms, masses and inertias."""
    assert len(ours.links) == model.nbody
    moving = [joint for joint in ours.joints if joint.moves]
    assert len(moving) == model.njnt
    for number, joint in enumerate(moving):
        check_joint(joint, model, number)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    for _ in range(STATES):
        state = {}
        for number, joint in enumerate(moving):
            at = model.jnt_qposadr[number]
            if joint.kind == "floating":
                quat = rng.normal(size=4)
                state[joint.name] = np.r_[rng.normal(size=3), quat / np.linalg.norm(quat)]
                data.qpos[at : at + 7] = state[joint.name]
            else:
                state[joint.name] = positions(joint, rng)
                data.qpos[at : at + (4 if joint.kind == "ball" else 1)] = state[joint.name]
        mujoco.mj_kinematics(model, data)
        X_RL = link_poses(ours, state)
        for number, link in enumerate(ours.links):
            X = pose(data.xmat[number].reshape(3, 3), data.xpos[number])
            np.testing.assert_allclose(X_RL[link.name], X, atol=1e-9)
    for number, link in enumerate(ours.links[1:], 1):
        check_mass(ours, link.name, model, number, root)
    check_geoms(ours, model)


def check_joint(joint: DescribedJoint, model: mujoco.MjModel, number: int) -> None:
    kinds = {"floating": 0, "ball": 1, "prismatic": 2, "revolute": 3, "continuous": 3}
    assert model.jnt_type[number] == kinds[joint.kind]
    if joint.kind == "floating":
        return
    name = model.joint(number).name
    assert not name or name == joint.name
    if joint.kind != "ball":
        np.testing.assert_allclose(model.jnt_axis[number], joint.axis_C, atol=1e-9)
    np.testing.assert_allclose(model.jnt_pos[number], joint.anchor_C, atol=1e-9)
    limited = joint.limits is not None and joint.limits.lower < joint.limits.upper
    assert bool(model.jnt_limited[number]) == limited
    if limited:
        np.testing.assert_allclose(model.jnt_range[number], present(joint.limits), atol=1e-9)
    at = model.jnt_dofadr[number]
    assert model.dof_frictionloss[at] == pytest.approx(joint.friction)
    assert model.dof_armature[at] == pytest.approx(joint.armature)


def check_mass(ours: RobotDescription, name: str, model: mujoco.MjModel, number: int, root: Path) -> None:
    link = next(link for link in ours.links if link.name == name)
    mass = link_mass(link, lambda mesh: mesh_volume(mesh, root))
    if mass is None:
        return
    settings = ours.settings.keys() & {"settotalmass", "boundmass", "boundinertia", "balanceinertia"}
    if settings or (any(shape.mesh is not None for shape in link.shapes) and link.inertia_source == "shapes"):
        return  # Masses after the settings; meshes have tests of their own.
    assert model.body_mass[number] == pytest.approx(mass.mass_kg, rel=1e-9)
    np.testing.assert_allclose(model.body_ipos[number], mass.centre_of_mass_m, atol=1e-9)
    R = matrix_of(model.body_iquat[number])
    tensor = R @ np.diag(model.body_inertia[number]) @ R.T
    np.testing.assert_allclose(tensor, mass.inertia_kgm2, atol=1e-6 * np.abs(mass.inertia_kgm2).max() + 1e-12)


def mesh_volume(mesh: MeshReference, root: Path) -> VolumeProperties | None:
    if not mesh.path or Path(mesh.path).suffix.lower() not in (".obj", ".stl"):
        return None
    loaded = trimesh.load_mesh(root / mesh.path, process=False)
    return enclosed_volume(in_shape_frame(mesh, np.asarray(loaded.vertices)), np.asarray(loaded.faces))


def check_geoms(ours: RobotDescription, model: mujoco.MjModel) -> None:
    """Number, sizes and poses of the primitive geoms of every body."""
    if "discardvisual" in ours.settings:
        return
    assert [len(link.shapes) for link in ours.links] == model.body_geomnum.tolist()
    geoms = [shape for link in ours.links for shape in link.shapes]
    for number, shape in enumerate(geoms):
        if shape.kind in ("box", "sphere", "cylinder", "capsule", "ellipsoid"):
            X = pose(matrix_of(model.geom_quat[number]), model.geom_pos[number])
            np.testing.assert_allclose(shape.X_LS, X, atol=1e-9)
            half = model.geom_size[number]
            size = {
                "box": 2.0 * half,
                "sphere": half[:1],
                "ellipsoid": half,
                "cylinder": [half[0], 2.0 * half[1]],
                "capsule": [half[0], 2.0 * half[1]],
            }[shape.kind]
            np.testing.assert_allclose(shape.size_m, size, atol=1e-9)
        collides = bool(model.geom_contype[number] or model.geom_conaffinity[number])
        assert shape.collides == collides


@pytest.mark.shared
def test_shared_files_are_among_the_cases(shared_assets: Path) -> None:
    assert sum(path.is_relative_to(shared_assets) for path in urdf_files()) >= 16
    assert sum(path.is_relative_to(shared_assets) for path in mjcf_files()) >= 11
