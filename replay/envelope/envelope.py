"""The swept envelope: capsules (W, m) that hold everything that moves, at every time between first and last stamp.

A capsule is a ball of a body's cover swept along a segment. Its radius is a sum: the ball, what its cover leaves out
(gap), the bound on the distance of the motion from the path (interval), that of the path from the segment
(simplification), and the clearance. Bodies that never move are obstacles: see `replay.insertion.free_space`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from replay.envelope.bounds import Paths, paths, turns
from replay.envelope.cover import Cover, cover
from replay.envelope.probes import Tolerances, refine_by_probes
from replay.envelope.simplify import simplify
from replay.envelope.trajectory import Trajectory, as_robot, recorded_trajectory, refined_trajectories
from replay.recording.episode import Episode, Robot, link_names
from replay.recording.kinematics import moving_links
from schemas.arrays import FloatArray, IntArray

_SAMPLE_BALLS = 8  # balls of a link by which the division of intervals is chosen
_MOST_PARTS = 1000  # of an interval; a leap that would need more makes wide capsules, not many
_EITHER_WAY_RAD = 1e-4  # this near to half a turn the direction of the rotation is unknown


@dataclass(frozen=True)
class Settings:
    """Tolerances of the envelope: protrusion of balls, largest distance from chords, simplification, clearance; metres.

    With `probes` intervals are probed as in the paper, and the tolerance of proxies replaces the bound: no proof.
    """

    protrusion_m: float = 0.006
    interval_m: float = 0.001
    simplification_m: float = 0.003
    clearance_m: float = 0.01
    probes: Tolerances | None = None


@dataclass(frozen=True)
class Envelope:
    """c capsules. start_W, end_W (c, 3); body (c,) indexes `bodies`; t_from_s, t_to_s (c,) when the body is there.

    proxy_m, gap_m, interval_m, simplification_m (c,) and clearance_m add up to the radius.
    """

    bodies: tuple[str, ...]
    covers: tuple[Cover, ...]
    body: IntArray
    start_W: FloatArray
    end_W: FloatArray
    t_from_s: FloatArray
    t_to_s: FloatArray
    proxy_m: FloatArray
    gap_m: FloatArray
    interval_m: FloatArray
    simplification_m: FloatArray
    clearance_m: float

    @property
    def radius_m(self) -> FloatArray:
        """(c,)."""
        return self.proxy_m + self.gap_m + self.interval_m + self.simplification_m + self.clearance_m


def swept_envelope(episode: Episode, settings: Settings) -> Envelope:
    """The envelope of all robots, articulated fixtures and objects of an episode, as far as they move.

    A body is called as its link; `<robot>/<link>` where two arms have a link of that name.
    """
    parts: list[tuple[str, Cover, tuple[FloatArray, ...]]] = []
    for robot in episode.robots:
        names = dict(zip((link.name for link in robot.links), link_names(episode, robot), strict=True))
        parts += [
            (names[link], ball_cover, capsules) for link, ball_cover, capsules in _swept(robot, episode.t_s, settings)
        ]
    for body in episode.objects:
        parts += _swept(as_robot(body), episode.t_s, settings)
    columns = [np.concatenate([p[2][k] for p in parts]) if parts else _NOTHING[k] for k in range(len(_NOTHING))]
    body = np.repeat(np.arange(len(parts)), [len(p[2][0]) for p in parts])
    names, covers = tuple(p[0] for p in parts), tuple(p[1] for p in parts)
    return Envelope(names, covers, body, *columns, clearance_m=settings.clearance_m)


_NOTHING = (np.zeros((0, 3)), np.zeros((0, 3)), *(np.zeros(0) for _ in range(6)))


def _swept(robot: Robot, t_s: FloatArray, settings: Settings) -> Iterator[tuple[str, Cover, tuple[FloatArray, ...]]]:
    moving = moving_links(robot)
    covers = [
        cover(link.shapes if number in moving else (), settings.protrusion_m) for number, link in enumerate(robot.links)
    ]
    sample_centres = [
        ball_cover.centres_B[:: max(1, len(ball_cover.radii_m) // _SAMPLE_BALLS)] for ball_cover in covers
    ]
    if settings.probes:
        trajectories = [refine_by_probes(robot, t_s, [ball_cover.centres_B for ball_cover in covers], settings.probes)]
    else:
        trajectories = _divided(
            robot, t_s, paths(robot, recorded_trajectory(robot, t_s), sample_centres), settings.interval_m
        )
    point_paths = [
        paths(robot, trajectory, [ball_cover.centres_B for ball_cover in covers]) for trajectory in trajectories
    ]
    for number, (link, ball_cover) in enumerate(zip(robot.links, covers, strict=True)):
        if len(ball_cover.radii_m):
            pieces = [
                _capsules(trajectory, along[number], ball_cover, settings)
                for trajectory, along in zip(trajectories, point_paths, strict=True)
            ]
            yield link.name, ball_cover, tuple(np.concatenate(column) for column in zip(*pieces, strict=True))


def _divided(robot: Robot, t_s: FloatArray, along: Sequence[Paths], interval_m: float) -> list[Trajectory]:
    """Trajectories whose intervals are divided where sample points may leave the chord by more than `interval_m`.

    Half a turn of a base stays undivided: its bound holds for both directions of rotation, that of its parts does not.
    """
    none = np.zeros((1, max(len(t_s) - 1, 0)))
    curve = np.max(np.concatenate([none, *(path.chord_error_m for path in along)]), axis=0)
    deviation = np.max(np.concatenate([none, *(path.joint_deviation_m for path in along)]), axis=0)
    is_half_turn = turns(robot.X_WR) > np.pi - _EITHER_WAY_RAD
    parts = np.where(is_half_turn, 1.0, np.ceil(np.sqrt(curve / interval_m))).clip(1.0, _MOST_PARTS)
    deviates = (deviation > interval_m) & ~is_half_turn
    hermite_parts = np.where(deviates, 1.0 + np.ceil(np.sqrt((curve + 4.0 * deviation) / interval_m)), 0.0).clip(
        0.0, _MOST_PARTS
    )
    return refined_trajectories(robot, t_s, parts.astype(int), hermite_parts.astype(int))


def _capsules(trajectory: Trajectory, path: Paths, balls: Cover, settings: Settings) -> tuple[FloatArray, ...]:
    spans = simplify(path.points_W, settings.simplification_m)
    error_bound_m = (
        path.error_bound_m if settings.probes is None else np.full_like(path.error_bound_m, settings.probes.proxy_m)
    )
    interval = _largest(error_bound_m, spans.line, spans.first, spans.last)
    return (
        path.points_W[spans.line, spans.first],
        path.points_W[spans.line, spans.last],
        trajectory.t_s[spans.first],
        trajectory.t_s[spans.last],
        balls.radii_m[spans.line],
        np.full(len(spans.line), balls.residual_m),
        interval,
        spans.deviation_m,
    )


def _largest(values: FloatArray, line: IntArray, first: IntArray, last: IntArray) -> FloatArray:
    """Largest of values[line, first:last] for each span (sorted by line and first, which share their ends)."""
    if values.shape[1] == 0:
        return np.zeros(len(line))
    return np.maximum.reduceat(values.reshape(-1), line * values.shape[1] + first)
