"""Masses of links against MuJoCo, which compiles the same file: every kind of geom, meshes, inferred and declared."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from formats import link_mass, read_mjcf
from formats.mesh_points import in_shape_frame
from geom.mass.inertia import enclosed_volume
from geom.pose import matrix_of
from schemas.physics import MassProperties, VolumeProperties
from schemas.robot_description import MeshReference
from tests.support.bad_inputs.robot import mjcf, write

PLACED = 'pos="0.1 0.2 0.3" euler="10 20 30"'
TETRAHEDRON = 'vertex="0 0 0 1 0 0 0 2 0 0 0 3" face="0 2 1 0 1 3 0 3 2 1 2 3"'
BODIES = {
    "box": f'<geom type="box" size="0.1 0.2 0.3" {PLACED}/>',
    "sphere": '<geom size="0.1" density="500"/>',
    "cylinder": f'<geom type="cylinder" size="0.1 0.2" mass="2" {PLACED}/>',
    "capsule": f'<geom type="capsule" size="0.1 0.2" {PLACED}/>',
    "capsule between points": '<geom type="capsule" size="0.1" fromto="0 0 0 1 2 3"/>',
    "box between points": '<geom type="box" size="0.1" fromto="0 0 0 1 2 3"/>',
    "ellipsoid": f'<geom type="ellipsoid" size="0.1 0.2 0.3" {PLACED}/>',
    "several": f'<geom size="0.2" mass="1"/><geom type="box" size="0.1 0.1 0.4" {PLACED}/>',
    "a group that does not count": '<geom size="0.2" group="1"/><geom size="0.9" group="3"/>',
    "a geom without mass": '<geom size="0.2"/><geom size="0.9" mass="0" pos="1 0 0"/>',
    "declared": '<inertial pos="1 2 3" mass="2" diaginertia="2 3 4" euler="10 20 30"/><geom size="1"/>',
    "full tensor": '<inertial pos="1 2 3" mass="2" fullinertia="2 3 4 0.1 0.2 0.3"/>',
    "mesh": f'<geom type="mesh" mesh="m" {PLACED}/>',
    "mesh with a mass": f'<geom type="mesh" mesh="m" mass="3" {PLACED}/>',
}
GROUPS = '<compiler inertiagrouprange="0 2"/>'
MESH = f'<asset><mesh name="m" {TETRAHEDRON} scale="0.1 0.2 0.1" refpos="0.5 0.1 0.2" refquat="1 0.2 0.3 1"/></asset>\n'


def volume(mesh: MeshReference) -> VolumeProperties:
    assert mesh.vertices is not None
    assert mesh.triangles is not None
    return enclosed_volume(in_shape_frame(mesh, mesh.vertices), mesh.triangles)


@pytest.mark.parametrize("name", BODIES)
def test_masses_are_those_of_mujoco(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log there.
    before = MESH if "mesh" in name else GROUPS
    path = write(mjcf(f'<body name="a"><joint/>{BODIES[name]}</body>', before), tmp_path)
    ours = link_mass(read_mjcf(path).links[1], volume)
    assert isinstance(ours, MassProperties)
    model = mujoco.MjModel.from_xml_path(str(path))
    assert ours.mass_kg == pytest.approx(model.body_mass[1], rel=1e-9)
    np.testing.assert_allclose(ours.centre_of_mass_m, model.body_ipos[1], atol=1e-7)
    R = matrix_of(model.body_iquat[1])
    tensor = R @ np.diag(model.body_inertia[1]) @ R.T
    np.testing.assert_allclose(ours.inertia_kgm2, tensor, rtol=1e-5, atol=1e-6 * np.abs(tensor).max())


def test_a_mesh_of_unknown_volume_makes_the_mass_unknown(tmp_path: Path) -> None:
    path = write(mjcf(f'<body name="a">{BODIES["mesh"]}<geom size="1"/></body>', MESH), tmp_path)
    assert link_mass(read_mjcf(path).links[1]) is None
