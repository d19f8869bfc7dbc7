"""Recordings with a description: our own folder, LeRobot, ManiSkill; forward kinematics against PyBullet."""

import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from replay.recording.formats.read import read_episode, read_episodes
from replay.recording.formats.write import write_variant
from replay.recording.kinematics import link_poses
from replay.verification.check_output import check_output
from replay.verification.link_check import check_links
from schemas.diagnostics import InvalidInput
from schemas.replay.documents import Variant
from tests.support import bullet_recordings
from tests.support.replay_samples import columns, write

BOX = {"type": "box", "size_m": [0.8, 1.2, 0.04]}
URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision><geometry><box size="0.3 0.05 0.05"/></geometry></collision></link>
  <link name="lower"><visual><geometry><sphere radius="0.04"/></geometry></visual></link>
  <link name="mirror"><collision><geometry><cylinder radius="0.02" length="0.1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 2"/></joint>
  <joint name="reach" type="prismatic"><parent link="upper"/><child link="lower"/><origin xyz="0.3 0 0"/></joint>
  <joint name="follow" type="prismatic"><parent link="upper"/><child link="mirror"/><axis xyz="0 1 0"/>
    <mimic joint="reach" multiplier="-2" offset="0.1"/></joint>
</robot>
"""
DESCRIPTION = {
    "robots": [{"name": "arm", "model": "arm.urdf", "position_m": [0, 0, 0.3]}],
    "objects": [{"name": "cube", "shapes": [{"type": "box", "size_m": [0.04, 0.04, 0.04]}]}],
    "fixtures": [{"name": "table", "shapes": [{"type": "box", "name": "top", "size_m": [0.8, 1.2, 0.04]}]}],
    "cameras": [{"name": "tip", "fovy_deg": 60, "robot": "arm", "link": "lower", "position_m": [0, 0, 0.1]}],
}


def described(folder: Path, **more: object) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(URDF)
    (folder / "episode.json").write_text(json.dumps(DESCRIPTION | more))
    return folder


def own(folder: Path, **more: object) -> Path:
    write(described(folder, **more) / "episode.parquet", columns())
    return folder


def refusal(path: Path) -> str:
    with pytest.raises(InvalidInput) as refused:
        read_episodes(path)
    return refused.value.diagnostic.code


@pytest.mark.parametrize("kind", ["sweep", "two_arms", "drawer"])
def test_links_of_pybullet_recordings_are_where_the_engine_has_them(tmp_path: Path, kind: str):
    folder = bullet_recordings.record(tmp_path, kind, seconds=0.5)
    episode = read_episode(folder, meshes=bullet_recordings.DATA)
    steps = np.diff(episode.t_s)
    assert (steps == 0.0).any()
    assert len(np.unique(steps)) > 3
    assert [r.name for r in episode.robots] == list(bullet_recordings.BASES[kind])
    errors = check_links(episode)
    assert len(errors) >= 12 * sum(name != "drawer" for name in bullet_recordings.BASES[kind])
    assert all(e.agrees for e in errors), [e for e in errors if not e.agrees]
    moving = [link for link in episode.robots[0].links if link.kind != "fixed"]
    assert all(link.shapes for link in moving)


def test_our_folder_is_read_as_described(tmp_path: Path):
    episode = read_episode(own(tmp_path / "one"))
    (robot,) = episode.robots
    assert robot.coordinates == ("turn", "reach")
    poses = link_poses(robot, robot.q, robot.X_WR)
    q = columns()["q.reach"]
    np.testing.assert_allclose(np.linalg.norm(poses[:, 2, :2, 3], axis=1), 0.3 + q, atol=1e-12)
    local = np.linalg.inv(poses[:, 1]) @ poses[:, 3]
    np.testing.assert_allclose(local[:, 1, 3], 0.1 - 2.0 * q, atol=1e-12)
    assert [[s.kind for s in link.shapes] for link in robot.links] == [[], ["box"], ["sphere"], ["cylinder"]]
    np.testing.assert_allclose(episode.cameras[0].X_WC[:, :3, 3], poses[:, 2, :3, 3] + [0, 0, 0.1], atol=1e-12)
    assert episode.name == "one"


def test_a_joint_that_stood_still_needs_no_column(tmp_path: Path):
    robots = [{"name": "arm", "model": "arm.urdf", "positions": {"reach": 0.1}}]
    rows = {k: v for k, v in columns().items() if "reach" not in k}
    write(described(tmp_path, robots=robots) / "episode.parquet", rows)
    robot = read_episode(tmp_path).robots[0]
    np.testing.assert_array_equal(robot.q[:, 1], 0.1)
    assert robot.qd is not None
    np.testing.assert_array_equal(robot.qd[:, 1], 0.0)


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"robots": [{"name": "arm", "model": "../arm.urdf"}]}, "replay/path-escape"),
        ({"robots": [{"name": "arm", "model": "none.urdf"}]}, "replay/missing-file"),
        ({"objects": [{"name": "ball", "shapes": [{"type": "sphere", "radius_m": 0.1}]}]}, "replay/missing-column"),
        ({"objects": [{"name": "cube", "shapes": [{"type": "sphere", "radius_m": -1}]}]}, "replay/invalid-value"),
        ({"objects": [{"name": "cube", "shapes": [{"type": "mesh", "file": "../a.obj"}]}]}, "replay/path-escape"),
        (
            {"objects": [{"name": "cube", "shapes": [{"type": "sphere", "radius_m": float("inf")}]}]},
            "replay/invalid-value",
        ),
        (
            {"fixtures": [{"name": "table", "shapes": [BOX | {"position_m": [0, 0, float("nan")]}]}]},
            "replay/invalid-value",
        ),
        ({"name": "../../elsewhere"}, "replay/invalid-value"),
        ({"name": "/elsewhere"}, "replay/invalid-value"),
        ({"fixture": []}, "replay/invalid-value"),
        ({"columns": {"q.turn": "observation[0]"}}, "replay/missing-column"),
    ],
)
def test_a_description_that_does_not_fit_is_refused(tmp_path: Path, changed: dict[str, object], code: str):
    assert refusal(own(tmp_path / "one", **changed)) == code


@pytest.mark.parametrize("size", ['box size="0.3 -0.05 0.05"', 'sphere radius="0"', 'cylinder radius="-1" length="1"'])
def test_shapes_of_no_size_or_less_are_refused(tmp_path: Path, size: str):
    """A negative radius made capsules that were too thin."""
    folder = own(tmp_path / "one")
    (folder / "arm.urdf").write_text(URDF.replace('box size="0.3 0.05 0.05"', size))
    assert refusal(folder) == "replay/invalid-value"


def lerobot(folder: Path, version: str) -> Path:
    """A data set of two episodes, in the layout of a version."""
    layout = {f"q.{name}": f"observation.state[{k}]" for k, name in enumerate(("turn", "reach"))}
    cube = ("px", "py", "pz", "qw", "qx", "qy", "qz")
    layout |= {f"obj.cube.{c}": f"observation.cube[{k}]" for k, c in enumerate(cube)}
    described(folder, columns=layout)
    (folder / "meta").mkdir()
    info = {"codebase_version": version, "fps": 20, "data_path": "data/..."}
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    tables = []
    for index in range(2):
        rows = columns(10 + index)
        n = len(rows["t"])
        state = np.stack([rows["q.turn"], rows["q.reach"]], axis=1).astype(np.float32)
        poses = np.stack([rows[f"obj.cube.{c}"] for c in cube], axis=1).astype(np.float32)
        tables.append(
            pa.table(
                {
                    "observation.state": pa.array(state.tolist(), pa.list_(pa.float32(), 2)),
                    "observation.cube": pa.array(poses.tolist(), pa.list_(pa.float32())),
                    "timestamp": np.arange(n, dtype=np.float32) / 20,
                    "source_timestamp": rows["t"],
                    "episode_index": np.full(n, index),
                }
            )
        )
    (folder / "data" / "chunk-000").mkdir(parents=True)
    if version.startswith("v3"):
        pq.write_table(pa.concat_tables(tables), folder / "data" / "chunk-000" / "file-000.parquet")
    else:
        for index, table in enumerate(tables):
            pq.write_table(table, folder / "data" / "chunk-000" / f"episode_{index:06d}.parquet")
    return folder


def empty_variant(source: Path) -> Variant:
    return Variant(
        episode="e", source=str(source), seed=0, number=0, clearance_m=0.01, objects_requested=0, inserted=()
    )


def test_a_log_of_a_real_robot_and_a_description_elsewhere(tmp_path: Path):
    log = {name: values for name, values in columns().items() if name[:2] in ("t", "q.")}
    (tmp_path / "logs").mkdir()
    write(tmp_path / "logs" / "monday.parquet", log)
    assert refusal(tmp_path / "logs" / "monday.parquet") == "replay/missing-file"
    scene = described(tmp_path / "cell", objects=[], name="cell") / "episode.json"
    (episode,) = read_episodes(tmp_path / "logs" / "monday.parquet", scene=scene)
    assert episode.name == "monday"
    np.testing.assert_array_equal(episode.robots[0].q[:, 0], log["q.turn"])
    write_variant(episode, empty_variant(tmp_path / "logs" / "monday.parquet"), tmp_path / "out")
    (check,) = check_output(tmp_path / "out", None, None)
    assert check.sound
    rows = pq.read_table(tmp_path / "out" / "recording" / "monday.parquet")
    (tmp_path / "out" / "recording" / "monday.parquet").unlink()
    pq.write_table(rows.slice(1), tmp_path / "out" / "recording" / "monday.parquet")
    assert not check_output(tmp_path / "out", None, None)[0].states_identical


def test_an_array_that_holds_no_points_is_refused(tmp_path: Path):
    keyed = {"type": "mesh", "file": "shapes.npz", "key": "flat"}
    data = own(tmp_path, objects=[{"name": "cube", "shapes": [keyed]}])
    np.savez(tmp_path / "shapes.npz", flat=np.zeros(12))
    assert refusal(data) == "replay/bad-mesh"


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_episodes_of_a_lerobot_data_set(tmp_path: Path, version: str):
    data = lerobot(tmp_path / "set", version)
    first, second = read_episodes(data)
    assert (first.part, second.part) == ("0", "1")
    np.testing.assert_array_equal(second.t_s, columns(11)["t"])
    np.testing.assert_array_equal(second.robots[0].q[:, 0], columns(11)["q.turn"].astype(np.float32))
    assert second.robots[0].qd is None
    done = write_variant(second, empty_variant(data), tmp_path / "out")
    tables = [name for name in done.source_sha256 if name.startswith("data")]
    assert tables == [f"data/chunk-000/{'file-000' if version == 'v3.0' else 'episode_000001'}.parquet"]
    assert check_output(tmp_path / "out", None, None)[0].sound
    again = next(e for e in read_episodes(tmp_path / "out" / done.recording) if e.part == "1")
    assert again.robots[0].q.tobytes() == second.robots[0].q.tobytes()


def test_another_version_of_lerobot_is_refused(tmp_path: Path):
    data = lerobot(tmp_path, "v2.1")
    (data / "meta" / "info.json").write_text('{"codebase_version": "v9"}')
    assert refusal(data) == "replay/unknown-format"


def test_trajectories_of_maniskill(tmp_path: Path):
    robots = [{"name": "arm", "model": "arm.urdf", "joints": ["turn", "reach"]}]
    described(tmp_path, robots=robots)
    entries = [{"episode_id": k, "elapsed_steps": len(columns()["t"]) - 1} for k in range(2)]
    about = {"env_info": {"env_kwargs": {"sim_config": {"control_freq": 20}}}, "episodes": entries}
    (tmp_path / "demo.json").write_text(json.dumps(about))
    rows = columns()
    n = len(rows["t"])
    cube = np.stack([rows[f"obj.cube.{c}"] for c in ("px", "py", "pz", "qw", "qx", "qy", "qz")], axis=1)
    base = np.tile([0.1, 0, 0, 1, 0, 0, 0], (n, 1))
    joints = np.stack([rows[f"{k}.{j}"] for k in ("q", "qd") for j in ("turn", "reach")], axis=1)
    with h5py.File(tmp_path / "demo.h5", "w") as file:
        for k in range(2):
            states = file.create_group(f"traj_{k}/env_states")
            states["actors/cube"] = np.hstack([cube, np.zeros((n, 6))]).astype(np.float32)
            states["articulations/arm"] = np.hstack([base, np.zeros((n, 6)), joints])
    episodes = read_episodes(tmp_path / "demo.h5")
    assert [e.part for e in episodes] == ["traj_0", "traj_1"]
    np.testing.assert_allclose(episodes[1].t_s, np.arange(n) / 20)
    np.testing.assert_array_equal(episodes[1].robots[0].q[:, 1], rows["q.reach"])
    np.testing.assert_array_equal(episodes[1].robots[0].X_WR[:, 0, 3], 0.1)
    out = tmp_path / "out"
    done = write_variant(episodes[1], empty_variant(tmp_path / "demo.h5"), out)
    assert list(done.source_sha256) == ["traj_1/env_states/actors/cube", "traj_1/env_states/articulations/arm"]
    assert check_output(out, None, None)[0].sound
    moved = done.model_copy(update={"scene": "", "source": "gone.h5"})
    (out / "variant.json").write_text(moved.model_dump_json())
    assert check_output(out, None, None)[0].sound  # All that is needed came along.
    copied = json.loads((out / "recording" / "demo.json").read_bytes())  # As ManiSkill's tools walk a file.
    assert copied == about | {"episodes": entries[1:]}
    with h5py.File(out / "recording" / "demo.h5") as file:
        [entry] = copied["episodes"]
        cubes = file[f"traj_{entry['episode_id']}/env_states/actors/cube"]
        assert isinstance(cubes, h5py.Dataset)
        assert len(cubes) == copied["episodes"][0]["elapsed_steps"] + 1
    with h5py.File(tmp_path / "demo.h5", "a") as file:
        del file["traj_1/env_states/actors/cube"]
        file["traj_1/env_states/actors/cube"] = np.hstack([cube, np.zeros((n, 6))])[1:]
    assert refusal(tmp_path / "demo.h5") == "replay/state-size"
    described(tmp_path, robots=[robots[0] | {"joints": ["turn"]}], control_hz=20)
    assert refusal(tmp_path / "demo.h5") == "replay/state-size"
