"""Written scenes: poses go through nested frames, external validators pass them, re-reading gives the same bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gate.external_validators import usd_validation
from geom.pose import matrix_of
from scenec.emit.scene import compiled_scene
from schemas.scene.compiled import CompiledScene
from schemas.scene.program import BoxAsset
from tests.support.scene.problems import table_setting
from usdio.reread.scene import reread_scene
from usdio.write.scene import write_scene


@pytest.fixture(scope="module")
def scene() -> CompiledScene:
    return compiled_scene(*table_setting(), seed=3)


def test_poses_go_through_every_frame(scene: CompiledScene):
    """The mug is at (0.1, 0.05) on a tray turned by 90 degrees at (0.2, 0) on a table turned by 30 degrees."""
    mug = next(o for o in scene.objects if o.id == "mug")
    turn = np.radians(30.0)
    on_table = np.array([0.2 - 0.05, 0.1])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    expected = [*(rotation @ on_table + [0.5, -0.2]), 0.72]
    np.testing.assert_allclose(mug.position_m, expected, atol=1e-9)
    yaw = np.arctan2(*matrix_of(np.array(mug.quat_wxyz))[[1, 0], [0, 0]])
    np.testing.assert_allclose(yaw, turn + np.pi / 2.0 + 0.3, atol=1e-8)
    assert mug.prisms[0].low_m == pytest.approx(0.72)
    assert mug.prisms[0].high_m == pytest.approx(0.82)


def test_an_unplaced_thing_is_no_scene():
    problem, placements = table_setting()
    del placements["book"]
    with pytest.raises(KeyError):
        compiled_scene(problem, placements, 0)


def test_outside_judges_pass(scene: CompiledScene, tmp_path: Path):
    verdict = usd_validation(write_scene(scene, None, tmp_path / "scene.usda"))
    assert verdict.passed, verdict.findings
    assert not verdict.warnings


def test_what_is_read_back_is_what_was_meant(scene: CompiledScene, tmp_path: Path):
    bodies = {b.name: b for b in reread_scene(write_scene(scene, None, tmp_path / "scene.usda"))}
    assert [b.name for b in bodies.values() if not b.moves] == ["background"]
    for item in scene.objects:
        read = bodies[item.id]
        np.testing.assert_allclose(read.X_WA[:3, 3], item.position_m, atol=1e-9)
        np.testing.assert_allclose(read.X_WA[:3, :3], matrix_of(np.array(item.quat_wxyz)), atol=1e-8)
        shape = read.body.shapes[0]
        assert isinstance(item.primitive, BoxAsset)
        np.testing.assert_allclose(shape.size_m, item.primitive.size_m, atol=1e-6)
        assert read.body.mass.mass_kg == pytest.approx(500.0 * np.prod(item.primitive.size_m), rel=1e-5)


def test_same_scene_same_bytes(scene: CompiledScene, tmp_path: Path):
    first, second = (write_scene(scene, None, tmp_path / name / "scene.usda").read_bytes() for name in "ab")
    assert first == second
