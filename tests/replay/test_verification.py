"""Distances against closed forms and brute force, paths between samples, and variants that verification refuses."""

import json
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from cli.main import app
from geom.convex.hull import convex_hull
from geom.pose import pose
from replay.recording.episode import Fixture
from replay.recording.formats.digests import stream_digests
from replay.recording.formats.read import read_episode, read_episodes
from replay.recording.formats.write import write_variant
from replay.verification.check_output import check_output, read_variant_episode, summary
from replay.verification.dense import between_poses, dense_motion, hermite_between
from replay.verification.inserted_bodies import inserted_body
from replay.verification.nearest import least_distance, moving_shape, static_shape
from replay.verification.separation import centre_and_radius, distance_shape, separation_m, support_coordinate
from replay.verification.verify import near_pairs
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape
from schemas.replay.documents import Inserted, Variant
from schemas.scene.program import BoxAsset
from sim.bullet.scene import settle_scene
from tests.support import bullet_recordings, replay_samples

BOX = CollisionShape("box", (0.2, 0.1, 0.06), np.eye(4))
BALL = CollisionShape("sphere", (0.05,), np.eye(4))
CAPSULE = CollisionShape("capsule", (0.03, 0.2), np.eye(4))
CYLINDER = CollisionShape("cylinder", (0.04, 0.1), np.eye(4))
seeds = st.integers(0, 2**32 - 1)


def random_hull(rng: np.random.Generator, size_m: float = 0.1) -> CollisionShape:
    return CollisionShape("hull", (), np.eye(4), *convex_hull(size_m * rng.normal(size=(20, 3))))


def random_pose(rng: np.random.Generator, spread_m: float = 0.4) -> np.ndarray:
    return pose(Rotation.random(rng=rng).as_matrix(), spread_m * rng.normal(size=3))


def at(x: float, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    return pose(None, (x, y, z))


@pytest.mark.parametrize(
    ("a", "b", "X", "expected"),
    [
        (BOX, BOX, at(0.5), 0.3),
        (BOX, BOX, at(0.3, 0.2), np.hypot(0.1, 0.1)),
        (BOX, BALL, at(0.3), 0.15),
        (BOX, BALL, at(0.2, 0.15, 0.13), np.sqrt(0.1**2 + 0.1**2 + 0.1**2) - 0.05),
        (BALL, CAPSULE, at(0.0, 0.2), 0.12),
        (BALL, CYLINDER, at(0.0, 0.0, 0.2), 0.1),
        (BOX, BOX, at(0.19), 0.0),
        (BOX, BALL, at(0.0), 0.0),
    ],
)
def test_distances_are_those_of_closed_forms(a: CollisionShape, b: CollisionShape, X: np.ndarray, expected: float):
    rng = np.random.default_rng(0)
    for X_W in (np.eye(4), random_pose(rng), random_pose(rng)):
        assert separation_m(distance_shape(a), X_W, distance_shape(b), X_W @ X) == pytest.approx(expected, abs=2e-6)
        assert separation_m(distance_shape(b), X_W @ X, distance_shape(a), X_W) == pytest.approx(expected, abs=2e-6)


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_a_distance_is_never_more_than_that_of_two_points_of_the_shapes(seed: int):
    rng = np.random.default_rng(seed)
    a, b = random_hull(rng), random_hull(rng)
    X_WA, X_WB = random_pose(rng), random_pose(rng)
    distance = separation_m(distance_shape(a), X_WA, distance_shape(b), X_WB)
    assert a.points is not None
    assert b.points is not None
    mix = rng.dirichlet(np.full(len(a.points), 0.1), 200)
    other = rng.dirichlet(np.full(len(b.points), 0.1), 200)
    p = (mix @ a.points) @ X_WA[:3, :3].T + X_WA[:3, 3]
    q = (other @ b.points) @ X_WB[:3, :3].T + X_WB[:3, 3]
    assert distance <= np.linalg.norm(p - q, axis=1).min() + 1e-12


@pytest.mark.parametrize("shape", [BOX, BALL, CAPSULE, CYLINDER])
def test_the_ball_around_a_shape_holds_it(shape: CollisionShape):
    centre, radius = centre_and_radius(distance_shape(shape))
    for direction in Rotation.random(20, rng=np.random.default_rng(1)).as_matrix()[:, 0]:
        assert support_coordinate(distance_shape(shape), np.eye(4), direction) <= direction @ centre + radius + 1e-12


@settings(max_examples=8, deadline=None)
@given(seed=seeds)
def test_branch_and_bound_finds_the_least_distance_of_all_times(seed: int):
    rng = np.random.default_rng(seed)
    X = np.stack([random_pose(rng) for _ in range(6)])
    X_WB = between_poses(X, np.arange(16) / 16)
    moving = distance_shape(random_hull(rng))
    still = static_shape(distance_shape(random_hull(rng)), random_pose(rng, 0.8))
    every = [separation_m(moving, X, still.distance_shape, still.X_WA) for X in X_WB]
    distance, row = least_distance(moving_shape(moving, X_WB), still, np.inf)
    assert distance == pytest.approx(min(every), abs=1e-9)
    assert every[row] == distance
    assert least_distance(moving_shape(moving, X_WB), still, 0.5 * distance) == (0.5 * distance, -1)


def test_cubics_meet_positions_and_rates_and_follow_a_cubic_exactly():
    t = np.array([0.0, 0.1, 0.1, 0.35])
    share = np.arange(4) / 4
    cubic = np.polynomial.Polynomial([0.1, -2.0, 3.0, 5.0])
    dense = hermite_between(cubic(t)[:, None], cubic.deriv()(t)[:, None], t, share)[:, 0]
    times = np.concatenate([(t[:-1, None] + share * np.diff(t)[:, None]).ravel(), t[-1:]])
    np.testing.assert_allclose(dense, cubic(times), atol=1e-12)


def test_poses_between_samples_turn_at_constant_rate():
    X = np.stack([pose(Rotation.from_euler("z", a).as_matrix(), (a, 0.0, 0.0)) for a in (0.0, 0.8, -1.0)])
    dense = between_poses(X, np.arange(4) / 4)
    angles = Rotation.from_matrix(dense[:, :3, :3]).as_euler("zyx")[:, 0]
    np.testing.assert_allclose(angles, dense[:, 0, 3], atol=1e-12)
    np.testing.assert_allclose(dense[::4], X, atol=1e-12)


def test_the_dense_replay_passes_every_sample(tmp_path: Path):
    episode = read_episode(replay_samples.staged(tmp_path))
    straight, cubic = dense_motion(episode)
    np.testing.assert_array_equal(straight.t_s[::16], episode.t_s)
    for stretch in (straight, cubic):
        cube = next(body for body in stretch.bodies if body.name == "cube")
        np.testing.assert_allclose(cube.X_WB[::16], episode.objects[0].X_WB, atol=1e-12)
    tips = [next(b for b in s.bodies if b.name == "lower").X_WB for s in (straight, cubic)]
    np.testing.assert_allclose(tips[0][::16], tips[1][::16], atol=1e-12)
    assert np.abs(tips[0] - tips[1]).max() > 1e-4


def boxed(x: float, y: float, name: str = "box", z: float = 0.22, **more: object) -> Inserted:
    return Inserted.model_validate(
        {
            "name": name,
            "asset_id": "box",
            "position_m": (x, y, z),
            "quat_wxyz": (1.0, 0.0, 0.0, 0.0),
            "support": "top",
            "primitive": BoxAsset(type="box", size_m=(0.05, 0.05, 0.1)),
            **more,
        }
    )


def variant(*inserted: Inserted, source: Path) -> Variant:
    return Variant(
        episode="arm",
        source=str(source),
        seed=0,
        number=0,
        clearance_m=0.01,
        objects_requested=len(inserted),
        inserted=inserted,
    )


def test_pairs_under_the_clearance_are_named_with_their_time(tmp_path: Path):
    episode = read_episode(replay_samples.staged(tmp_path))
    clear, hit, close = boxed(0.8, 0.5), boxed(0.42, 0.0, z=0.221), boxed(0.5, 0.5, "other")
    beside = boxed(0.8 + 0.055, 0.5, "beside")
    variants = [[clear], [hit], [clear, beside, close]]
    pairs = near_pairs(episode, [[inserted_body(one, None) for one in some] for some in variants], 0.01)
    assert pairs[0][0].distance_m > 0.01
    touching = {pair.other for pair in pairs[1] if pair.distance_m == 0.0}
    assert touching == {"lower"}
    first = next(pair for pair in pairs[1] if pair.other == "lower")
    assert first.t_s is not None
    assert episode.t_s[0] <= first.t_s <= episode.t_s[-1]
    assert pairs[2][0].other in ("beside", "box")
    assert pairs[2][0].distance_m == pytest.approx(0.005, abs=1e-6)


def test_a_wall_that_bears_the_name_of_the_support_is_no_support(tmp_path: Path):
    """Two fixtures may have a shape called `top`; the one that stands in the way was left out."""
    episode = read_episode(replay_samples.staged(tmp_path))
    wall = Fixture("shelf", at(0.8, 0.5, 0.3), (BOX,), ("top",))
    (pairs,) = near_pairs(
        replace(episode, fixtures=(*episode.fixtures, wall)), [[inserted_body(boxed(0.8, 0.5), None)]], 0.01
    )
    assert [(pair.other, pair.distance_m) for pair in pairs] == [("top", 0.0)]


def test_variants_of_one_motion_in_two_scenes_are_judged_each_in_its_own(tmp_path: Path):
    """A table of a real robot, described twice: once with a wall where the box stands."""
    table = tmp_path / "log.parquet"
    replay_samples.write(table, {"t": np.arange(3) * 0.1})
    for number, y in enumerate((0.5, 5.0)):
        wall = {"name": "wall", "position_m": [0.8, y, 0.3], "shapes": [{"type": "box", "size_m": [0.2, 0.2, 0.4]}]}
        scene = tmp_path / f"scene_{number}.json"
        scene.write_text(json.dumps({"fixtures": [wall]}))
        (episode,) = read_episodes(table, None, scene)
        write_variant(episode, variant(boxed(0.8, 0.5), source=table), tmp_path / "out" / str(number))
    assert [check.contacts for check in check_output(tmp_path / "out", None, None)] == [1, 0]


def test_a_copy_without_the_part_that_is_named_is_refused(tmp_path: Path):
    source = replay_samples.robomimic(tmp_path / "demo.hdf5", demos=1)
    done = write_variant(read_episode(source), variant(source=source), tmp_path / "out")
    with pytest.raises(InvalidInput) as refused:
        read_variant_episode(tmp_path / "out", done.model_copy(update={"part": "data/demo_1"}))
    assert refused.value.diagnostic.code == "replay/missing-file"


def test_a_rotated_world_gives_the_same_distances(tmp_path: Path):
    """Yaw and shift of the whole recording change nothing."""
    episode = read_episode(replay_samples.staged(tmp_path))
    X = pose(Rotation.from_euler("z", 0.7).as_matrix(), (0.3, -0.2, 0.1))
    turned = replace(
        episode,
        robots=tuple(replace(r, X_WR=X @ r.X_WR) for r in episode.robots),
        objects=tuple(replace(o, X_WB=X @ o.X_WB) for o in episode.objects),
        fixtures=tuple(replace(f, X_WB=X @ f.X_WB) for f in episode.fixtures),
    )
    one = inserted_body(boxed(0.5, 0.15), None)
    (before,), (after,) = (
        near_pairs(e, [[replace(one, X_WA=Y @ one.X_WA)]], 0.01) for e, Y in ((episode, np.eye(4)), (turned, X))
    )
    assert [(p.other, p.t_s) for p in before] == [(p.other, p.t_s) for p in after]
    assert [p.distance_m for p in before] == pytest.approx([p.distance_m for p in after], abs=1e-6)


def test_two_arms_and_a_drawer_are_seen_with_their_names(tmp_path: Path):
    """A box is put where only one of them comes by."""
    drawer = read_episode(bullet_recordings.record(tmp_path / "drawer", "drawer", seconds=0.5), bullet_recordings.DATA)
    (pairs,) = near_pairs(drawer, [[inserted_body(boxed(0.37, 0.3, z=0.0, support="table_top"), None)]], 0.01)
    assert "tray" in {pair.other for pair in pairs if pair.distance_m == 0.0}
    arms = read_episode(bullet_recordings.record(tmp_path / "arms", "two_arms", seconds=0.25), bullet_recordings.DATA)
    hand = next(body for body in next(dense_motion(arms)).bodies if body.name == "right/panda_hand")
    x, y, z = hand.X_WB[len(hand.X_WB) // 2, :3, 3]
    (pairs,) = near_pairs(arms, [[inserted_body(boxed(x, y, z=z - 0.05), None)]], 0.01)
    assert {pair.other for pair in pairs if pair.distance_m == 0.0} & {"right/panda_hand", "right/panda_link7"}
    assert not any(pair.other.startswith("left/") for pair in pairs)


@pytest.mark.parametrize("kind", ["folder", "hdf5"])
def test_variants_keep_every_stream_bit_for_bit_and_are_checked_from_disk(tmp_path: Path, kind: str):
    source = tmp_path / "source"
    recording = replay_samples.staged(source)
    if kind == "hdf5":
        recording = replay_samples.robomimic(tmp_path / "files" / "demo.hdf5")
    episode = read_episodes(recording)[-1]
    good = write_variant(episode, variant(boxed(0.8, 0.5), source=recording), tmp_path / "out" / "arm" / "0")
    bad = write_variant(
        episode,
        variant(boxed(0.38, 0.0), boxed(0.8, 0.5, "tilted", z=0.3), source=recording),
        tmp_path / "out" / "arm" / "1",
    )
    assert good.source_sha256 == stream_digests(tmp_path / "out" / "arm" / "0" / good.recording, good.part)
    assert any(name.endswith(("states", "episode.parquet")) for name in good.source_sha256)
    again = read_variant_episode(tmp_path / "out" / "arm" / "0", good)
    assert again.t_s.tobytes() == episode.t_s.tobytes()
    assert again.robots[0].q.tobytes() == episode.robots[0].q.tobytes()
    assert bad.inserted[1].name == "tilted"
    checks = check_output(tmp_path / "out", None, settle_scene)
    assert [check.sound for check in checks] == [True, False]
    assert [check.states_identical for check in checks] == [True, True]
    assert [thing.stayed for check in checks for thing in check.moved][0::2] == [True, False]
    figures = summary(checks)
    assert figures["variants"] == 2
    assert figures["contacts"] > 0
    assert figures["settle_failures"] >= 1


def test_a_changed_stamp_in_the_copy_is_found(tmp_path: Path):
    source = replay_samples.robomimic(tmp_path / "demo.hdf5", demos=1)
    done = write_variant(read_episode(source), variant(source=source), tmp_path / "out")
    with h5py.File(tmp_path / "out" / done.recording, "a") as file:
        states = file["data/demo_9/states"]
        assert isinstance(states, h5py.Dataset)
        states[3, 0] = np.nextafter(states[3, 0], 1.0)
    assert not check_output(tmp_path / "out", None, None)[0].states_identical


def test_a_variant_whose_recording_lies_elsewhere_is_refused(tmp_path: Path):
    source = replay_samples.staged(tmp_path / "source")
    done = write_variant(read_episode(source), variant(source=source), tmp_path / "out")
    moved = done.model_copy(update={"recording": "../source"})
    (tmp_path / "out" / "variant.json").write_text(moved.model_dump_json())
    with pytest.raises(InvalidInput) as refused:
        check_output(tmp_path / "out", None, None)
    assert refused.value.diagnostic.code == "replay/path-escape"


def test_the_command_tells_what_is_near_and_fails(tmp_path: Path):
    source = replay_samples.staged(tmp_path / "source")
    write_variant(read_episode(source), variant(boxed(0.38, 0.0), source=source), tmp_path / "out")
    ran = CliRunner().invoke(app, ["replay", "verify", str(tmp_path / "out"), "--json"])
    assert ran.exit_code == 1, ran.output
    answer = json.loads(ran.stdout)
    assert {"variants", "objects_requested", "objects_inserted", "contacts", "clearance_m"} <= answer.keys()
    assert answer["contacts"] == 1
    assert answer["unsound"][0]["near"][0]["other"] == "lower"
