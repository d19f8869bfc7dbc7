"""Pictures of variants: depth and instances are those of exact rays, and hidden pixels those that are counted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from cli.main import app
from cli.replay.frames import draw_variant
from geom.pose import quat_of
from replay.recording.formats.read import read_episode
from replay.verification.inserted_bodies import inserted_body
from replay.views import visibility
from replay.views.visibility import TaskPixels, convex_polyhedra, in_world, newly_hidden, task_pixels
from schemas.diagnostics import InvalidInput
from schemas.replay.documents import Inserted
from tests.replay.test_variant_stage import BOX, variant_in
from tests.support import replay_samples

ROW = 4  # With the row after it at the same stamp.


def look_down(source: Path) -> None:
    """The recorded camera before the cube, looking down on it at an angle."""
    X = np.column_stack([[0.0, 1.0, 0.0], [-0.53, 0.0, 0.848], [0.848, 0.0, 0.53]])
    w, x, y, z = quat_of(X / np.linalg.norm(X, axis=0)).tolist()
    front = {"fovy_deg": 20.0, "pose_xyz_qxyzw": [1.3, -0.03, 0.7, x, y, z, w]}
    (source / "scene.json").write_text(json.dumps({"cameras": {"front": front}}))


def half_before(eye: np.ndarray, target: np.ndarray) -> Inserted:
    """The box between a camera and an object, so that one of its sides passes near the line of sight."""
    along = (target - eye) / np.linalg.norm(target - eye)
    aside = np.cross(along, [0.0, 0.0, 1.0])
    aside = aside / np.linalg.norm(aside)
    R_WA = np.column_stack([along, aside, np.cross(along, aside)])
    at = eye + 0.5 * (target - eye) + 0.042 * aside - 0.06 * R_WA[:, 2]
    return BOX.model_copy(update={"position_m": tuple(at.tolist()), "quat_wxyz": tuple(quat_of(R_WA).tolist())})


def test_pictures_agree_with_rays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    source = replay_samples.staged(tmp_path / "source")
    look_down(source)
    episode = read_episode(source)
    (camera,) = episode.cameras
    monkeypatch.setattr(visibility, "LONGEST_PX", max(camera.width_px, camera.height_px))
    cube = episode.objects[0]
    box = half_before(camera.X_WC[ROW, :3, 3], cube.X_WB[ROW, :3, 3])
    folder, out = variant_in(tmp_path / "0", source, box), tmp_path / "pictures"
    command = ["replay", "render", str(folder), "--out", str(out), "--cameras", camera.name, "--every", str(ROW)]
    result = CliRunner().invoke(app, [*command, "--json"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["frames"] == 3

    frames = json.loads((out / "frames.json").read_text())
    number = next(int(key) for key, thing in frames["instances"].items() if thing["name"] == "cube")
    frame = frames["cameras"][camera.name]["frames"][1]
    assert (frame["row"], frame["t_s"]) == (ROW, episode.t_s[ROW])
    ids, depth_mm, rgb = (
        np.asarray(Image.open(out / camera.name / kind / frame["file"])) for kind in ("instances", "depth", "rgb")
    )
    assert rgb.shape == (camera.height_px, camera.width_px, 3)
    assert np.ptp(rgb) > 50

    (without,) = task_pixels(episode, [camera], [ROW])
    body = inserted_body(box, None)
    screen = [in_world(convex, body.X_WA) for convex in convex_polyhedra(body.body.shapes)]
    share = newly_hidden([without], screen)[camera.name]
    assert 0.2 < share < 0.8
    assert np.count_nonzero(ids == number) == pytest.approx((1.0 - share) * len(without.depths), rel=0.03)
    seen_m = depth_mm[ids == number] / 1000.0
    assert without.depths.min() - 1e-3 <= seen_m.min() <= seen_m.max() <= without.depths.max() + 1e-3
    assert_depth(without, depth_mm, ids == number, frames["cameras"][camera.name], frame["X_WC"])


def assert_depth(
    seen: TaskPixels, depth_mm: np.ndarray, shown: np.ndarray, lens: dict, X_WC: list[list[float]]
) -> None:
    """Rays of pixels that show the object have the depth of the picture, by what frames.json says of the lens."""
    points_C = (seen.directions @ np.array(X_WC)[:3, :3]) * [1.0, -1.0, -1.0]
    x, y = (points_C[:, :2] * lens["focal_px"] + lens["centre_px"]).T.astype(int)
    there = shown[y, x]
    assert there.any()
    np.testing.assert_allclose(depth_mm[y, x][there] / 1000.0, seen.depths[there], atol=6e-4)


def test_a_camera_that_is_not_there(tmp_path: Path):
    folder = variant_in(tmp_path / "0", replay_samples.staged(tmp_path / "source"), BOX)
    result = CliRunner().invoke(app, ["replay", "render", str(folder), "--out", str(tmp_path), "--cameras", "moon"])
    assert result.exit_code == 2
    assert "no camera 'moon'" in " ".join(result.output.split())


def test_a_camera_whose_name_leads_out_of_the_folder_draws_nothing(tmp_path: Path):
    """The name of a camera comes from the recording, the folder of its pictures from its name."""
    source = replay_samples.staged(tmp_path / "source")
    (source / "scene.json").write_text(json.dumps({"cameras": {"../away": replay_samples.CAMERA["front"]}}))
    folder = variant_in(tmp_path / "0", source, BOX)
    with pytest.raises(InvalidInput) as refused:
        draw_variant(folder, tmp_path / "out", None, None, [], 6, quiet=True)
    assert refused.value.diagnostic.code == "replay/path-escape"
    assert not (tmp_path / "away").exists()


def test_compose_command(tmp_path: Path):
    folder = variant_in(tmp_path / "0", replay_samples.staged(tmp_path / "source"), BOX)
    result = CliRunner().invoke(app, ["replay", "compose", str(folder)])
    assert result.exit_code == 0, result.output
    assert (folder / "replay.usda").is_file()
