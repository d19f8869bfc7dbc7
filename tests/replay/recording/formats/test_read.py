"""Staged recordings: what is read, and forward kinematics against MuJoCo and recorded link poses."""

import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import h5py.h5o
import mujoco
import numpy as np
import pytest

from replay.recording.files import archives, hdf5
from replay.recording.formats.digests import stream_digests
from replay.recording.formats.read import read_episode, read_episodes
from replay.recording.kinematics import link_poses
from replay.recording.mjcf.bodies import RecordedBodies
from replay.recording.mjcf.episode_parts import episode_parts
from replay.recording.recorded_numbers import RecordedStates
from replay.recording.robot_files import recorded_mjcf
from replay.run import recordings_below
from replay.verification.link_check import check_links
from schemas.diagnostics import InvalidInput
from tests.support import replay_samples

TIP_SIZE_M = (0.1, 0.04, 0.04)
STAGED = Path(__file__).parents[5] / "shared" / "data" / "episodes"

# Every way to write a rotation, classes, frames, chains of joints in one body, anchors and references.
ODD = """<mujoco>
  <compiler angle="%s" eulerseq="%s"/>
  <default><joint axis="0 1 0"/><geom size="0.01"/>
    <default class="slide"><joint type="slide" axis="1 1 0"/></default></default>
  <worldbody>
    <body name="base" pos="0.1 0.2 0.3" euler="10 20 30" childclass="slide">
      <geom/>
      <body name="a" axisangle="1 2 3 0.5" pos="0 0 1">
        <joint name="j0" class="main" pos="0.1 0 0.2"/>
        <joint name="j1" ref="0.1"/><joint name="j2" type="hinge" ref="5"/>
        <geom/>
        <frame pos="0 1 0" zaxis="1 1 1">
          <body name="b" xyaxes="0 1 0 -1 0.2 0">
            <joint name="j3" type="hinge" pos="0 0 0.3" axis="1 0 0"/><geom/></body>
        </frame>
        <body name="c" quat="1 1 0 0"><geom/></body>
      </body>
    </body>
    <body name="cart"><freejoint name="free"/><geom/>
      <body name="wheel" pos="0 0.3 0"><joint name="j4" type="hinge"/><geom/></body></body>
  </worldbody>
</mujoco>"""


@pytest.mark.parametrize(("angle", "order"), [("degree", "xyz"), ("radian", "ZYX"), ("radian", "zXy")])
def test_kinematics_of_a_model_are_those_of_mujoco(tmp_path: Path, angle: str, order: str):
    text = ODD % (angle, order)
    (tmp_path / "odd.xml").write_text(text)
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    rng = np.random.default_rng(1)
    data.qpos[:] = rng.normal(size=theirs.nq)
    data.qpos[theirs.jnt_qposadr[theirs.joint("free").id] + 3 :][:4] /= np.linalg.norm(data.qpos[-5:-1])
    mujoco.mj_kinematics(theirs, data)
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = data.body("cart").xmat.reshape(3, 3), data.body("cart").xpos
    q = {f"j{k}": data.joint(f"j{k}").qpos.copy() for k in range(5)}
    recorded = RecordedStates(np.zeros(1), q, {}, {"cart": X[None]})
    bodies = RecordedBodies(recorded_mjcf(tmp_path / "odd.xml", tmp_path))
    robots, objects, _ = episode_parts(bodies, recorded, lambda *_: np.zeros((0, 3)))
    assert [r.name for r in robots] == ["base", "cart"]
    assert not objects
    for robot in robots:
        poses = link_poses(robot, robot.q, robot.X_WR)[0]
        found = {link.name: X for link, X in zip(robot.links, poses, strict=True)}
        for name in {"base": "abc", "cart": ("cart", "wheel")}[robot.name]:
            body = data.body(name)
            np.testing.assert_allclose(found[name][:3, 3], body.xpos, atol=1e-12)
            np.testing.assert_allclose(found[name][:3, :3], body.xmat.reshape(3, 3), atol=1e-12)


def test_a_staged_folder_is_read_as_it_moved(tmp_path: Path):
    episode = read_episode(replay_samples.staged(tmp_path))
    np.testing.assert_array_equal(episode.t_s, replay_samples.stamps())
    (robot,) = episode.robots
    assert [link.name for link in robot.links] == ["arm", "upper", "lower"]
    assert [link.kind for link in robot.links] == ["fixed", "revolute", "prismatic"]
    assert [shape.kind for link in robot.links for shape in link.shapes] == ["cylinder", "capsule", "hull"]
    assert [fixture.shape_names for fixture in episode.fixtures] == [("floor",), ("top",)]
    assert [body.name for body in episode.objects] == ["cube"]
    assert [camera.name for camera in episode.cameras] == ["front"]
    tip = link_poses(robot, robot.q, robot.X_WR)[-1, 2]
    expected = np.array([0.5 * np.cos(0.6), 0.5 * np.sin(0.6), 0.3])
    np.testing.assert_allclose(tip[:3, 3], expected, atol=1e-12)


def test_cameras_that_moved_need_a_pose_for_every_sample(tmp_path: Path):
    folder = replay_samples.staged(tmp_path)
    short = replay_samples.columns(8)
    rename_columns = {k.replace("obj.cube", "front"): v for k, v in short.items() if k.startswith("obj.")}
    replay_samples.write(folder / "camera_moving.parquet", rename_columns)
    with pytest.raises(InvalidInput) as refused:
        read_episode(folder)
    assert refused.value.diagnostic.code == "replay/state-size"


def test_what_the_table_leaves_out_comes_from_the_raw_states(tmp_path: Path):
    whole = read_episode(replay_samples.staged(tmp_path / "whole"))
    rows = {k: v for k, v in replay_samples.columns().items() if "reach" not in k and "cube" not in k}
    folder = replay_samples.staged(tmp_path / "part", rows)
    assert refusal(folder) == "replay/missing-column"
    replay_samples.robomimic(folder / "raw" / "demo.hdf5")
    completed = read_episode(folder)
    np.testing.assert_array_equal(completed.robots[0].q, whole.robots[0].q)
    np.testing.assert_array_equal(completed.objects[0].X_WB, whole.objects[0].X_WB)
    rows["t"] = rows["t"] + 1e-9
    replay_samples.write(folder / "episode.parquet", rows)
    assert refusal(folder) == "replay/missing-column"


def test_a_moving_link_that_is_only_drawn_is_told_when_its_mesh_is_absent(tmp_path: Path):
    drawn = '<geom type="mesh" mesh="tip" contype="0" conaffinity="0"/>'
    model = replay_samples.MODEL.replace('<geom type="mesh" mesh="tip"/>', drawn)
    episode = read_episode(replay_samples.staged(tmp_path / "with", model=model))
    assert not episode.notes
    assert episode.robots[0].links[2].shapes
    episode = read_episode(replay_samples.staged(tmp_path / "without", model=model, meshes=False))
    assert [note.code for note in episode.notes] == ["replay/uncovered-link"]
    assert "'lower'" in episode.notes[0].headline


def test_every_demonstration_of_a_file_is_an_episode(tmp_path: Path):
    nine, ten = read_episodes(replay_samples.robomimic(tmp_path / "demo.hdf5"))
    assert (nine.part, ten.part) == ("data/demo_9", "data/demo_10")
    assert (len(nine.t_s), len(ten.t_s)) == (12, 13)
    folder = read_episode(replay_samples.staged(tmp_path / "staged"))
    np.testing.assert_array_equal(nine.t_s, folder.t_s)
    np.testing.assert_array_equal(nine.robots[0].q, folder.robots[0].q)
    np.testing.assert_array_equal(nine.objects[0].X_WB, folder.objects[0].X_WB)
    assert [camera.name for camera in nine.cameras] == ["wrist"]
    wrist = link_poses(nine.robots[0], nine.robots[0].q, nine.robots[0].X_WR)[:, 2, :3, 3] + [0.0, 0.0, 0.1]
    np.testing.assert_allclose(nine.cameras[0].X_WC[:, :3, 3], wrist, atol=1e-12)


def refusal(path: Path, meshes: Path | None = None) -> str:
    with pytest.raises(InvalidInput) as refused:
        read_episodes(path, meshes)
    return refused.value.diagnostic.code


def test_states_of_another_model_are_refused(tmp_path: Path):
    model = replay_samples.MODEL.replace('<joint name="reach" type="slide" axis="1 0 0"/>', "")
    assert refusal(replay_samples.robomimic(tmp_path / "demo.hdf5", model)) == "replay/state-size"


def test_links_to_other_files_are_not_followed(tmp_path: Path):
    path = replay_samples.robomimic(tmp_path / "demo.hdf5")
    with h5py.File(path, "a") as file:
        del file["data/demo_9/states"]
        file["data/demo_9/states"] = h5py.ExternalLink(str(tmp_path / "other.hdf5"), "states")
    assert refusal(path) == "replay/path-escape"


def test_a_link_within_the_file_does_not_lead_out_of_it_through_another(tmp_path: Path):
    other = replay_samples.robomimic(tmp_path / "other" / "demo.hdf5")
    path = replay_samples.robomimic(tmp_path / "demo.hdf5")
    with h5py.File(path, "a") as file:
        del file["data/demo_9/states"]
        file["out"] = h5py.ExternalLink(str(other), "data/demo_9")
        file["data/demo_9/states"] = h5py.SoftLink("/out/states")
    assert refusal(path) == "replay/path-escape"


def test_a_model_that_is_no_utf8_is_read_with_marks_or_refused(tmp_path: Path):
    path = replay_samples.robomimic(tmp_path / "demo.hdf5")
    with h5py.File(path, "a") as file:
        model = hdf5.text(file["data/demo_9"].attrs["model_file"]).encode()
        odd = model.replace(b'model="', b'model="\x80', 1)
        assert b"\x80" in odd
        kind = h5py.string_dtype("utf-8")
        file["data/demo_9"].attrs.create("model_file", np.array(odd, dtype=object), dtype=kind)
    assert len(read_episodes(path)) >= 1


def test_links_in_a_circle_are_refused_and_plain_ones_are_followed(tmp_path: Path):
    path = replay_samples.robomimic(tmp_path / "demo.hdf5")
    before = read_episodes(path)
    with h5py.File(path, "a") as file:
        file.move("data/demo_9/states", "data/demo_9/real")
        file["data/demo_9/states"] = h5py.SoftLink("/data/demo_9/./again")
        file["data/demo_9/again"] = h5py.SoftLink("real")
    assert [episode.t_s.tolist() for episode in read_episodes(path)] == [episode.t_s.tolist() for episode in before]
    with h5py.File(path, "a") as file:
        del file["data/demo_9/again"]
        file["data/demo_9/again"] = h5py.SoftLink("/data/demo_9/states")
    assert refusal(path) == "replay/unreadable"


def test_a_file_that_is_a_link_out_of_its_folder_is_not_opened(tmp_path: Path):
    other = replay_samples.robomimic(tmp_path / "other" / "demo.hdf5")
    path = tmp_path / "folder" / "demo.hdf5"
    path.parent.mkdir()
    path.symlink_to(other)
    assert refusal(path) == "replay/path-escape"
    beside = other.with_name("same.hdf5")
    beside.symlink_to(other.name)
    assert len(read_episodes(beside)) == len(read_episodes(other))


def truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3000])


def overwritten(path: Path) -> None:
    with h5py.File(path) as file:
        at = h5py.h5o.get_info(file["data/demo_10/states"].id).addr
    data = bytearray(path.read_bytes())
    data[at : at + 24] = bytes([255]) * 24
    path.write_bytes(data)


def endless(path: Path) -> None:
    """The first free block of the first heap of names is followed by itself (HDF5 format, III.D)."""
    data = bytearray(path.read_bytes())
    _, free, names = struct.unpack_from("<3Q", data, data.index(b"HEAP") + 8)
    struct.pack_into("<Q", data, names + free, free)
    path.write_bytes(data)


@pytest.mark.parametrize("damage", [truncated, overwritten, endless])
def test_damaged_files_are_refused_and_the_rest_of_a_folder_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: Callable[[Path], None]
):
    monkeypatch.setattr(hdf5, "PATIENCE_S", 1.5)
    path = replay_samples.robomimic(tmp_path / "bad.hdf5")
    replay_samples.robomimic(tmp_path / "good.hdf5")
    damage(path)
    assert refusal(path) == "replay/unreadable"
    found = list(recordings_below(tmp_path))
    assert [file.name for file in found] == ["bad.hdf5", "good.hdf5"]


def test_a_group_that_holds_itself_has_an_end(tmp_path: Path):
    path = replay_samples.robomimic(tmp_path / "demo.hdf5")
    with h5py.File(path, "a") as file:
        file["data/demo_9/again"] = file["data/demo_9"]
    (nine, _) = read_episodes(path)
    with pytest.raises(InvalidInput, match="without end"):
        stream_digests(path, nine.part)


def test_archives_of_meshes_are_bounded_and_hold_no_pickles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = replay_samples.staged(tmp_path)
    file = folder / "meshes_body_frame.npz"
    whole = file.read_bytes()
    monkeypatch.setattr(archives, "MAX_UNPACKED_BYTES", 400)
    assert refusal(folder) == "replay/unreadable"
    monkeypatch.undo()
    file.write_bytes(whole[:-30])
    assert refusal(folder) == "replay/unreadable"
    np.savez(file, **{"lower|geom4|v": np.array([{}], dtype=object)}, allow_pickle=True)
    assert refusal(folder) == "replay/unreadable"
    file.unlink()
    assert refusal(folder) == "replay/missing-mesh"


def test_meshes_that_a_model_names_elsewhere_are_found_by_the_end_of_their_path(tmp_path: Path):
    model = replay_samples.MODEL.replace("tip.stl", "/elsewhere/assets/arm/tip.stl")
    path = replay_samples.robomimic(tmp_path / "demo" / "demo.hdf5", model)
    assert refusal(path) == "replay/missing-mesh"
    for folder in ("arm", "hand"):
        (tmp_path / "assets" / folder).mkdir(parents=True)
        replay_samples.TIP.export(tmp_path / "assets" / folder / "tip.stl")
    shape = read_episodes(path, tmp_path / "assets")[0].robots[0].links[2].shapes[0]
    assert shape.points is not None
    np.testing.assert_allclose(np.ptp(shape.points, axis=0), TIP_SIZE_M, atol=1e-6)
    (tmp_path / "assets" / "arm" / "tip.stl").unlink()
    (tmp_path / "assets" / "more").mkdir()
    replay_samples.TIP.export(tmp_path / "assets" / "more" / "tip.stl")
    assert refusal(path, tmp_path / "assets") == "replay/missing-mesh"


@pytest.mark.shared
@pytest.mark.parametrize("name", ["panda_lift", "panda_pick_place", "panda_stack"])
def test_the_raw_file_holds_the_same_motion_as_the_folder(name: str):
    folder, raw = read_episode(STAGED / name), read_episode(STAGED / name / "raw" / "demo.hdf5")
    np.testing.assert_array_equal(folder.t_s, raw.t_s)
    np.testing.assert_array_equal(folder.robots[0].q, raw.robots[0].q)
    for a, b in zip(folder.objects, raw.objects, strict=True):
        np.testing.assert_array_equal(a.X_WB, b.X_WB)
    recorded = {camera.name: camera for camera in folder.cameras}
    for camera in raw.cameras:
        np.testing.assert_allclose(camera.X_WC, recorded[camera.name].X_WC, atol=1e-12)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["panda_lift", "panda_pick_place", "panda_stack"])
def test_recorded_link_poses_are_those_of_the_model(name: str):
    errors = check_links(read_episode(STAGED / name))
    assert {f"robot0_link{k}" for k in range(1, 8)} <= {e.link for e in errors}
    assert all(e.agrees for e in errors)
