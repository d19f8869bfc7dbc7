"""What inserted bodies newly hide, against closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geom.pose import pose
from replay.recording.episode import Camera, Episode, Fixture, FreeBody
from replay.views.visibility import convex_polyhedra, in_world, newly_hidden, task_pixels
from schemas.physics import CollisionShape

TARGET = CollisionShape("box", (0.2, 0.2, 0.01), np.eye(4))
SCREEN = CollisionShape("box", (2.0, 2.0, 0.01), np.eye(4))
RIGHT, LEFT = pose(None, (1.0, 0.0, -1.0)), pose(None, (-1.0, 0.0, -1.0))  # Half planes between camera and target.
BEHIND = pose(None, (0.0, 0.0, -3.0))


def looked_at(X: np.ndarray, fixture: np.ndarray | None = None) -> Episode:
    """A camera at X, 2 m in front of a target, with a fixed screen at a pose as the camera sees it."""
    return Episode(
        name="one",
        source=Path(),
        t_s=np.zeros(1),
        robots=(),
        objects=(FreeBody("target", (X @ pose(None, (0.0, 0.0, -2.0)))[None], (TARGET,)),),
        fixtures=() if fixture is None else (Fixture("screen", X @ fixture, (SCREEN,), ("screen",)),),
        cameras=(Camera("front", X[None], np.radians(20.0)),),
    )


def hidden(episode: Episode, X_WB: np.ndarray) -> float:
    return newly_hidden(task_pixels(episode), [in_world(convex_polyhedra([SCREEN])[0], X_WB)])["front"]


@pytest.mark.parametrize("seed", range(3))
def test_half_is_hidden_by_a_screen_before_one_half(seed: int):
    rng = np.random.default_rng(seed)
    X = pose(Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)) if seed else np.eye(4)
    episode = looked_at(X)
    assert hidden(episode, X @ RIGHT) == 0.5
    assert hidden(episode, X @ BEHIND) == 0.0
    assert hidden(episode, X @ pose(None, (0.0, 0.0, -1.0))) == 1.0
    assert hidden(episode, X @ pose(None, (0.0, 0.0, 1.0))) == 0.0  # behind the camera


def test_what_is_hidden_anyway_does_not_count():
    episode = looked_at(np.eye(4), fixture=LEFT)
    assert hidden(episode, RIGHT) == 1.0
    assert hidden(episode, LEFT @ pose(None, (0.0, 0.0, 0.2))) == 0.0


def test_seen_pixels_are_those_whose_middle_the_target_covers():
    """A square of 0.2 m whose face is 1.995 m away, in a picture of 20 degrees."""
    (seen,) = task_pixels(looked_at(np.eye(4)))
    edge_px = 128 * 0.2 / (2.0 * 1.995 * np.tan(np.radians(10.0)))
    assert len(seen.depths) == (2 * round(edge_px / 2.0)) ** 2
    np.testing.assert_allclose(seen.depths, 1.995, atol=1e-9)


def test_large_pictures_and_cameras_that_see_nothing():
    episode = looked_at(np.eye(4))
    wide = replace(episode.cameras[0], width_px=1280, height_px=720)
    assert newly_hidden(task_pixels(episode, [wide]), []) == {"front": 0.0}
    away = replace(episode.cameras[0], X_WC=pose(None, (0.0, 0.0, -5.0))[None])
    assert newly_hidden(task_pixels(episode, [away]), []) == {}
