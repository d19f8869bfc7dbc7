"""Link poses of joints that no engine of the outside judges has: planar, floating in URDF, mimics; and references."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from formats import link_poses, read_mjcf, read_urdf
from tests.support.bad_inputs.robot import AB, joint, link, mjcf, urdf, write

SHIFT = '<origin xyz="1 2 3"/>'


def test_a_planar_joint_moves_in_the_plane_normal_to_its_axis(tmp_path: Path) -> None:
    text = urdf(AB, joint("j", "a", "b", "planar", SHIFT + '<axis xyz="0 0 1"/>'))
    X_RL = link_poses(read_urdf(write(text, tmp_path)), {"j": (0.1, 0.2, np.pi / 2)})
    np.testing.assert_allclose(X_RL["b"][:3, 3], [1.1, 2.2, 3.0])
    np.testing.assert_allclose(X_RL["b"][:3, 0], [0.0, 1.0, 0.0], atol=1e-12)
    sloped = urdf(AB, joint("j", "a", "b", "planar", '<axis xyz="1 1 0"/>'))
    moved = link_poses(read_urdf(write(sloped, tmp_path)), {"j": (0.3, -0.4, 0.0)})["b"][:3, 3]
    assert abs(moved @ [1.0, 1.0, 0.0]) < 1e-12
    np.testing.assert_allclose(np.linalg.norm(moved), 0.5)


def test_a_floating_joint_is_at_its_pose_in_the_parent(tmp_path: Path) -> None:
    text = urdf(AB, joint("j", "a", "b", "floating", SHIFT))
    description = read_urdf(write(text, tmp_path))
    np.testing.assert_allclose(link_poses(description, {})["b"][:3, 3], [1.0, 2.0, 3.0])
    X = link_poses(description, {"j": (4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 1.0)})["b"]
    np.testing.assert_allclose(X[:3, 3], [4.0, 5.0, 6.0])
    np.testing.assert_allclose(np.diag(X)[:3], [-1.0, -1.0, 1.0])


def test_mimics_follow_through_mimics_unless_they_have_a_position(tmp_path: Path) -> None:
    def follows(name: str, multiplier: float, offset: float) -> str:
        return f'<axis xyz="1 0 0"/><mimic joint="{name}" multiplier="{multiplier}" offset="{offset}"/>'

    text = urdf(
        *(link(n) for n in "abcd"),
        joint("i", "a", "b", "prismatic"),
        joint("j", "a", "c", "prismatic", follows("i", -2.0, 0.1)),
        joint("k", "a", "d", "prismatic", follows("j", 3.0, 1.0)),
    )
    description = read_urdf(write(text, tmp_path))
    X_RL = link_poses(description, {"i": 0.5})
    np.testing.assert_allclose([X_RL[n][0, 3] for n in "bcd"], [0.5, -0.9, -1.7])
    X_RL = link_poses(description, {"i": 0.5, "j": 0.2})
    np.testing.assert_allclose([X_RL[n][0, 3] for n in "bcd"], [0.5, 0.2, 1.6])


def test_links_without_positions_are_where_the_file_has_them(tmp_path: Path) -> None:
    text = mjcf(
        '<body name="a" pos="1 0 0"><joint name="j" type="slide" axis="1 0 0" ref="0.5"/><geom size="1"/></body>'
    )
    description = read_mjcf(write(text, tmp_path))
    assert link_poses(description, {})["a"][0, 3] == 1.0
    assert link_poses(description, {"j": 0.75})["a"][0, 3] == 1.25
