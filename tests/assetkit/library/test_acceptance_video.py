"""GIFs of the gripper at work: what moved in the simulation moves in the picture, and nothing else."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from assetkit.acceptance.suites.fixture import FixtureSuite
from assetkit.acceptance.suites.suite import NOMINAL
from assetkit.library.acceptance_video import BOXES, cropped, with_gripper, write_video
from assetkit.library.drawn_package import drawn_package
from geom.pose import pose
from schemas.appearance.material import Material
from sim.bullet.simulator import BulletSimulator
from sim.grasp_trial import GraspTrace
from tests.assetkit.acceptance.suites.test_fixture import GOOD, SLIDE_USE, subject
from tests.support.drawn import RED, box, model


def frames_of(file: Path) -> list[np.ndarray]:
    with Image.open(file) as gif:
        pictures = []
        for k in range(getattr(gif, "n_frames", 1)):
            gif.seek(k)
            pictures.append(np.asarray(gif.convert("RGB")).astype(int))
    return pictures


def red_at(picture: np.ndarray) -> np.ndarray:
    """(2,) mean column and row of what is red, not orange."""
    rows, columns = np.nonzero((picture[..., 0] > 2 * picture[..., 1]) & (picture[..., 0] > 60))
    return np.array([columns.mean(), rows.mean()])


def lifted(rows: int, by_m: float) -> GraspTrace:
    """A body that rises with a gripper above it."""
    heights = np.linspace(0.0, by_m, rows)
    X_WA = np.stack([pose(None, (0.0, 0.0, z)) for z in heights])
    at = [(-0.03, 0.0, 0.12), (0.03, 0.0, 0.12), (0.0, 0.0, 0.2)]
    X_WB = np.stack([np.stack([pose(None, (x, y, z + h)) for x, y, h in at]) for z in heights])
    half_m = np.array([[0.005, 0.01, 0.03], [0.005, 0.01, 0.03], [0.05, 0.03, 0.05]])
    return GraspTrace(np.linspace(0.0, 6.0, rows), X_WA, X_WB, half_m)


def test_a_body_that_is_lifted_rises_in_the_picture(tmp_path: Path) -> None:
    red = model(box((0.05, 0.05, 0.1), (0.0, 0.0, 0.05)), materials=(Material("red", base_color=RED),))
    out = write_video(red, lifted(120, 0.3), (), tmp_path / "lift.gif", frames=4, size_px=120)
    assert out is not None
    frames = frames_of(out)
    assert 4 <= len(frames) <= 5
    heights = [red_at(frame)[1] for frame in (frames[0], frames[len(frames) // 2], frames[-1])]
    assert heights[0] > heights[1] + 5 > heights[2] + 10


def test_the_joint_of_the_trace_is_opened_in_the_picture(tmp_path: Path) -> None:
    made = subject(GOOD, tmp_path, SLIDE_USE)
    with BulletSimulator() as simulator:
        run = FixtureSuite().run(made, simulator, NOMINAL)
    drawn = drawn_package(made.main_file, made.content)
    assert drawn.mechanism is not None
    out = write_video(drawn, None, run.handled, tmp_path / "drawer.gif", frames=4, size_px=120)
    assert out is not None
    frames = frames_of(out)
    changed = [int((np.abs(frame - frames[0]).max(axis=2) > 40).sum()) for frame in frames]
    assert max(changed) > 3 * changed[-1] > 0  # Shut again at the end, the hand back where it came from.


def test_nothing_is_written_where_nothing_moved(tmp_path: Path) -> None:
    assert write_video(model(box((0.1, 0.1, 0.1))), None, (), tmp_path / "none.gif") is None
    assert not list(tmp_path.iterdir())


def test_the_gripper_is_three_boxes_of_their_own_links() -> None:
    shown = with_gripper(model(box((0.1, 0.1, 0.1))))
    assert [mesh.link for mesh in shown.meshes] == ["", *BOXES]
    for mesh in shown.meshes[1:]:
        assert np.ptp(mesh.points, axis=0) == pytest.approx(np.ones(3))


def test_margins_that_are_empty_in_all_pictures_are_cut_off() -> None:
    images = [Image.new("RGB", (100, 80), (238, 238, 238)) for _ in range(2)]
    images[0].putpixel((40, 30), (0, 0, 0))
    images[1].putpixel((60, 50), (0, 0, 0))
    pictures: list[bytes] = []
    for image in images:
        file = io.BytesIO()
        image.save(file, "PNG")
        pictures.append(file.getvalue())
    first, second = (Image.open(io.BytesIO(data)) for data in cropped(pictures))
    assert first.size == second.size == (45, 45)
    assert first.getpixel((12, 12)) == (0, 0, 0)
    assert second.getpixel((32, 32)) == (0, 0, 0)
