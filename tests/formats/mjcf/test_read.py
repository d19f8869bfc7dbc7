"""MJCF files as a whole: depth, places across includes, cameras; damaged files never crash the reader."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from formats import link_poses, parse_mjcf, read_mjcf
from schemas.diagnostics import InvalidInput
from tests.support.bad_inputs.robot import mjcf, write
from tests.support.present import present

BODIES = 10_000
MOST_CPU_S = 10.0  # ten thousand bodies take about 1.5 s; quadratic time would be minutes


@pytest.mark.parametrize("shape", ["chain", "star"])
def test_ten_thousand_bodies_take_linear_time(shape: str, tmp_path: Path) -> None:
    """However deep: MuJoCo's own parser gives up before."""
    inside = '<joint axis="0 0 1"/><geom size="0.1"/>'
    starts = [f'<body name="b{k}" pos="0.001 0 0">{inside}' for k in range(BODIES)]
    text = "".join(starts) + "</body>" * BODIES if shape == "chain" else "</body>".join(starts) + "</body>"
    path = write(mjcf(text), tmp_path)
    began_s = time.process_time()
    description = read_mjcf(path)
    X_RL = link_poses(description, {})
    np.testing.assert_allclose(X_RL[f"b{BODIES - 1}"][0, 3], 0.001 * (BODIES if shape == "chain" else 1))
    assert time.process_time() - began_s < MOST_CPU_S


def test_a_model_in_a_recording_includes_files_beside(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<mujoco>\n<body name="a"><geom size="1"/></body></mujoco>')
    description = parse_mjcf(b'<mujoco><worldbody><include file="a.xml"/></worldbody></mujoco>', "demo.hdf5", tmp_path)
    assert [(e.name, *e.source) for e in description.links] == [("world", "demo.hdf5", 1), ("a", "a.xml", 2)]


def test_cameras_that_follow_something_are_marked(tmp_path: Path) -> None:
    cameras = '<camera name="c" fovy="60"/><camera name="d" mode="trackcom"/><camera name="e" orthographic="true"/>'
    description = read_mjcf(write(mjcf(cameras), tmp_path))
    assert [(c.name, c.fixed) for c in description.links[0].cameras] == [("c", True), ("d", False), ("e", False)]
    assert description.links[0].cameras[0].fovy_rad == pytest.approx(np.pi / 3)


def test_colors_come_from_the_geom_over_its_material(tmp_path: Path) -> None:
    assets = '<asset><texture name="t" type="2d" file="t.png"/><material name="m" texture="t" rgba="1 0 0 1"/></asset>'
    geoms = '<geom size="1" material="m"/><geom size="1" material="m" rgba="0 1 0 1"/><geom size="1"/>'
    text = mjcf(geoms, f'<compiler texturedir="pictures"/>{assets}')
    red, green, none = (s.material for s in read_mjcf(write(text, tmp_path)).links[0].shapes)
    assert red is not None
    assert green is not None
    assert (red.rgba, red.texture) == ((1.0, 0.0, 0.0, 1.0), "pictures/t.png")
    assert (green.rgba, green.texture) == ((0.0, 1.0, 0.0, 1.0), "pictures/t.png")
    assert none is None


@pytest.mark.shared
def test_the_shared_microwave_has_its_hinge(shared_assets: Path) -> None:
    folder = shared_assets / "mjcf" / "libero_microwave_mjcf"
    (hinge,) = [j for j in read_mjcf(folder / "microwave.xml").joints if j.moves]
    assert (hinge.name, hinge.kind) == ("microjoint", "revolute")
    np.testing.assert_allclose(present(hinge.limits), (-2.094, 0.0))
    assert np.abs(hinge.axis_C).tolist() == [0.0, 0.0, 1.0]


SMALL = (
    b'<mujoco><compiler angle="radian"/><default><geom size="1"/><default class="c"/></default>'
    b'<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset><worldbody><frame pos="1 0 0">'
    b'<body name="a" quat="1 0 0 0"><joint name="j" range="0 1"/><geom class="c" fromto="0 0 0 1 1 1" type="box"/>'
    b'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></frame></worldbody>'
    b'<equality><joint joint1="j" polycoef="0 1"/></equality></mujoco>'
)


@given(st.lists(st.tuples(st.integers(0, len(SMALL) - 1), st.binary(max_size=6)), min_size=1, max_size=4))
def test_damaged_files_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, damage: list[tuple[int, bytes]]
) -> None:
    data = SMALL
    for at, inserted in damage:
        data = data[:at] + inserted + data[at + 1 :]
    path = tmp_path_factory.mktemp("fuzz") / "model.xml"
    path.write_bytes(data)
    with contextlib.suppress(InvalidInput):
        read_mjcf(path)
