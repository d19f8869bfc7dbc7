"""Between two states no point leaves its chord by more than the bound: revolute, prismatic, turning bases, cubics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.pose import pose
from replay.envelope.bounds import paths
from replay.envelope.probes import Tolerances, refine_by_probes
from replay.envelope.trajectory import base_poses, recorded_trajectory, refined_trajectories
from replay.recording.episode import Link, Robot
from replay.recording.kinematics import link_poses

N, SUB = 6, 64


def chain(rng, kinds, turning=False, rates=True):
    """A robot of random links and motion over N rows."""
    links = []
    for number, kind in enumerate(kinds):
        axis = rng.normal(size=3)
        X = pose(Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.3, 0.3, 3))
        links.append(
            Link(f"l{number}", number - 1, kind, axis / np.linalg.norm(axis), X, number, rng.uniform(-1.5, 1.5))
        )
    q = np.cumsum(rng.uniform(-0.4, 0.4, (N, len(kinds))), axis=0)
    base = np.tile(np.eye(4), (N, 1, 1))
    if turning:
        base = np.stack(
            [
                pose(Rotation.from_rotvec(v).as_matrix(), p)
                for v, p in zip(rng.normal(size=(N, 3)) * 0.3, rng.normal(size=(N, 3)) * 0.2, strict=True)
            ]
        )
    qd = rng.uniform(-4.0, 4.0, q.shape) if rates else None
    return Robot("r", tuple(links), tuple(f"j{k}" for k in range(len(kinds))), base, q, qd)


def stamps(rng):
    return np.cumsum(rng.uniform(0.01, 0.08, N))


def beyond_chords(robot, trajectory, q_at, at, points):
    """By how much points at states q_at (m, SUB, j) leave their chords, over the bound; (links, ...)."""
    link_paths = paths(robot, trajectory, points)
    worst = -np.inf
    for number, path in enumerate(link_paths):
        for k in range(len(trajectory.t_s) - 1):
            X = link_poses(robot, q_at[k], base_poses(robot.X_WR, at[k]))[:, number]
            moving = np.einsum("sij,pj->psi", X[:, :3, :3], points[number]) + X[:, :3, 3]
            a, b = path.points_W[:, k], path.points_W[:, k + 1]
            along = b - a
            share = np.clip(
                np.einsum("psi,pi->ps", moving - a[:, None], along) / np.maximum((along**2).sum(1), 1e-300)[:, None],
                0,
                1,
            )
            away = np.linalg.norm(moving - a[:, None] - share[:, :, None] * along[:, None], axis=2).max(axis=1)
            worst = max(worst, float((away - path.error_bound_m[:, k]).max()))
    return worst


@settings(max_examples=30)
@given(
    st.integers(0, 100_000), st.lists(st.sampled_from(["revolute", "prismatic"]), min_size=1, max_size=5), st.booleans()
)
def test_joint_linear_motion_stays_within_the_bound(seed, kinds, turning):
    rng = np.random.default_rng(seed)
    robot, t_s = chain(rng, kinds, turning, rates=False), stamps(rng)
    trajectory = recorded_trajectory(robot, t_s)
    share = np.linspace(0.0, 1.0, SUB)
    at = np.arange(N - 1)[:, None] + share
    q_at = robot.q[:-1, None] + share[:, None] * np.diff(robot.q, axis=0)[:, None]
    points = [rng.uniform(-0.2, 0.2, (3, 3)) for _ in robot.links]
    assert beyond_chords(robot, trajectory, q_at, at, points) <= 1e-9


@settings(max_examples=30)
@given(st.integers(0, 100_000), st.booleans())
def test_the_cubic_through_recorded_rates_stays_within_the_bound(seed, apart):
    """On the recorded chain by its stray; on a chain of its own where it is taken apart."""
    rng = np.random.default_rng(seed)
    robot, t_s = chain(rng, ["revolute", "prismatic", "revolute"]), stamps(rng)
    parts = np.full(N - 1, 3)
    trajectories = refined_trajectories(robot, t_s, parts, parts + 1 if apart else 0 * parts)
    assert len(trajectories) == 1 + apart
    per = 4 if apart else 3
    share = np.linspace(0.0, 1.0, SUB)
    at = (np.arange(per * (N - 1))[:, None] + share) / per
    q_at = cubic(robot, t_s, at)
    points = [rng.uniform(-0.2, 0.2, (3, 3)) for _ in robot.links]
    assert beyond_chords(robot, trajectories[-1], q_at, at, points) <= 1e-9


def cubic(robot, t_s, at):
    """Hermite's basis written out, by another formula than the code under test uses."""
    row = np.minimum(at.astype(int), N - 2)
    s = (at - row)[..., None]
    h = np.diff(t_s)[row][..., None]
    q0, q1, v0, v1 = robot.q[row], robot.q[row + 1], robot.qd[row], robot.qd[row + 1]
    h00, h10 = 2 * s**3 - 3 * s**2 + 1, s**3 - 2 * s**2 + s
    return h00 * q0 + h10 * h * v0 + (1 - h00) * q1 + (s**3 - s**2) * h * v1


def test_dividing_an_interval_by_two_takes_three_quarters_of_the_bound():
    rng = np.random.default_rng(4)
    robot, t_s = chain(rng, ["revolute"] * 3, rates=False), stamps(rng)
    points = [rng.uniform(-0.2, 0.2, (4, 3)) for _ in robot.links]
    whole, halved = (
        paths(robot, refined_trajectories(robot, t_s, np.full(N - 1, n), np.zeros(N - 1, dtype=int))[0], points)
        for n in (1, 2)
    )
    for one, two in zip(whole, halved, strict=True):
        assert (two.chord_error_m.reshape(4, -1, 2).max(axis=2) <= 0.36 * one.chord_error_m + 1e-15).all()


def test_a_turning_bar_leaves_its_chord_by_nearly_as_much_as_the_bound_says():
    """Radius r, angle a: the sagitta r (1 - cos a/2) is r a^2 / 8 for small a."""
    link = Link("bar", -1, "revolute", np.array([0.0, 0.0, 1.0]), np.eye(4), 0)
    robot = Robot("r", (link,), ("j",), np.tile(np.eye(4), (2, 1, 1)), np.array([[0.0], [0.1]]))
    path = paths(robot, recorded_trajectory(robot, np.array([0.0, 0.05])), [np.array([[0.7, 0.0, 0.2]])])[0]
    assert path.error_bound_m[0, 0] == pytest.approx(0.7 * 0.1**2 / 8.0, rel=0.05)
    assert path.error_bound_m[0, 0] >= 0.7 * (1.0 - np.cos(0.05))


def test_probes_find_small_turns_small_enough_and_halve_larger_ones():
    """A bar of 0.7 m: at 0.2 rad a turn its middle leaves the chord by 3.5 mm, at 0.1 rad by 0.9 mm."""
    link = Link("bar", -1, "revolute", np.array([0.0, 0.0, 1.0]), np.eye(4), 0)
    robot = Robot("r", (link,), ("j",), np.tile(np.eye(4), (3, 1, 1)), np.array([[0.0], [0.2], [0.2]]))
    t_s, points = np.array([0.0, 0.1, 0.2]), [np.array([[0.7, 0.0, 0.2]])]
    assert refine_by_probes(robot, t_s, points, Tolerances(0.004, joint=1.0)).t_s.tolist() == [0.0, 0.1, 0.2]
    assert refine_by_probes(robot, t_s, points, Tolerances(0.001, joint=1.0)).t_s.tolist() == [0.0, 0.05, 0.1, 0.2]
    by_joint = refine_by_probes(robot, t_s, points, Tolerances(0.004, joint=0.06))
    assert by_joint.t_s.tolist() == pytest.approx([0.0, 0.025, 0.05, 0.075, 0.1, 0.2])


def test_repeated_stamps_are_joined_by_a_line_without_rates():
    link = Link("bar", -1, "revolute", np.array([0.0, 0.0, 1.0]), np.eye(4), 0)
    rates = np.full((3, 1), 5.0)
    robot = Robot("r", (link,), ("j",), np.tile(np.eye(4), (3, 1, 1)), np.array([[0.0], [0.1], [0.1]]), rates)
    trajectory = recorded_trajectory(robot, np.array([0.0, 0.0, 0.05]))
    assert trajectory.deviation[0, 0] == 0.0
    assert trajectory.deviation[1, 0] > 0.0
