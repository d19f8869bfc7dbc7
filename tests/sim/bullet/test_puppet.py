"""The object puppet carries exactly, lets fall what it lets go, and records truthfully what touches what."""

from __future__ import annotations

import numpy as np
import pytest

from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.task.state_log import StateLog
from sim.bullet.puppet import HAND, RATE_HZ, Carry, Wait, puppet_log
from tests.support.sample_bodies import box

SIDE_M, SLAB_M = 0.04, 0.02


def at(x: float, z: float, y: float = 0.0) -> FloatArray:
    """(4, 4) upright at a place."""
    return pose(None, np.array([x, y, z]))


def played(*script: Carry | Wait) -> StateLog:
    """Two cubes on a slab."""
    slab, cube = box((1.0, 1.0, SLAB_M)), box((SIDE_M,) * 3)
    bodies = [("table", slab, at(0.0, 0.0), False), ("a", cube, at(-0.2, SLAB_M), True)]
    bodies.append(("b", cube, at(0.2, SLAB_M), True))
    return puppet_log(bodies, script)


def column(log: StateLog, body: str) -> FloatArray:
    """(n, 3) places of a body."""
    return log.position_m[:, log.body_index[body]]


def touching(log: StateLog, one: str, other: str) -> np.ndarray:
    """(n,) whether two bodies touch."""
    number = log.contacts_of.get(one, {}).get(other)
    assert log.touching is not None
    return np.zeros(len(log), dtype=bool) if number is None else log.touching[:, number]


def test_a_script_gives_a_sound_log_and_the_same_one_again() -> None:
    script = (Wait(0.2), Carry("a", np.stack([at(-0.2, SLAB_M), at(-0.2, 0.2), at(0.2, 0.2)]), 1.0), Wait(0.5))
    log, again = played(*script), played(*script)
    assert log.faults() == []
    assert log.grippers == (HAND,)
    assert np.diff(log.t_s)[:-1] == pytest.approx(1.0 / RATE_HZ, abs=1e-9)
    assert log.position_m.tobytes() == again.position_m.tobytes()
    assert log.touching is not None
    assert again.touching is not None
    assert log.touching.tobytes() == again.touching.tobytes()


def test_it_carries_along_the_line_and_lets_go_onto_the_other_cube() -> None:
    top = SLAB_M + SIDE_M + 0.002
    log = played(
        Wait(0.2), Carry("a", np.stack([at(-0.2, SLAB_M), at(-0.2, 0.2), at(0.2, 0.2), at(0.2, top)]), 1.5), Wait(1.0)
    )
    fingers = [touching(log, finger, "a") for finger in HAND.fingers]
    carried = (log.t_s >= 0.2) & (log.t_s < 1.7)
    for each in fingers:
        assert (each[1:-1] == carried[1:-1]).mean() > 0.95
    on_the_way = column(log, "a")[(log.t_s > 0.75) & (log.t_s < 1.1)]
    assert on_the_way[:, 2] == pytest.approx(0.2, abs=0.002)
    assert np.all(np.diff(on_the_way[:, 0]) > 0.0)
    assert column(log, "a")[-1] == pytest.approx([0.2, 0.0, SLAB_M + SIDE_M], abs=0.001)
    assert touching(log, "a", "b")[-1]
    assert not touching(log, "a", "table")[-1]
    assert touching(log, "b", "table")[-1]


def test_what_is_let_go_in_the_air_falls_and_what_is_held_does_not() -> None:
    up = np.stack([at(-0.2, SLAB_M), at(-0.2, 0.3)])
    fallen = played(Carry("a", up, 0.5), Wait(1.0))
    held = played(Carry("a", up, 0.5, hold=True), Wait(1.0))
    assert column(fallen, "a")[-1, 2] == pytest.approx(SLAB_M, abs=0.002)
    assert column(held, "a")[-1, 2] == pytest.approx(0.3, abs=0.002)
    assert touching(held, "hand/left", "a")[-1]
    assert not touching(fallen, "hand/left", "a")[-1]


def test_what_is_in_the_way_is_pushed() -> None:
    log = played(Carry("a", np.stack([at(-0.2, SLAB_M), at(0.3, SLAB_M)]), 2.0), Wait(0.3))
    assert column(log, "b")[-1, 0] > 0.3
    assert touching(log, "a", "b").any()
