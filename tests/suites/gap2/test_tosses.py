"""Tosses: closed forms of flight and sliding, equals of a free flight, levels, files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.diagnostics import Severity
from simgap.recording.read import read
from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox, move
from tests.suites.gap2.generate.cases import write_case
from tests.suites.gap2.generate.tosses.cases import toss_case
from tests.suites.gap2.generate.truth import FAMILIES

FLYING = Box(np.array([0.1, 0.2, 0.3]), 0.8, 0.4, slides=False)
SLIDING = Box(np.array([0.1, 0.2, 0.06]), 0.8, 0.4, slides=True)
WITH_EFFECT = 3  # a flight under another gravity


def start(v: list[float], w: list[float]) -> np.ndarray:
    return np.array([[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, *v, *w]])


def test_flight_is_a_parabola_that_keeps_its_spin() -> None:
    t = np.linspace(0.0, 0.8, 41)[None]
    out = move(FLYING, HiddenInBox(), t, start([1.0, 2.0, 3.0], [4.0, -3.0, 2.0]))[0]
    expected = np.stack([t[0], 2.0 * t[0], 1.0 + 3.0 * t[0] - 0.5 * GRAVITY * t[0] ** 2], axis=1)
    assert out[:, :3] == pytest.approx(expected, abs=1e-9)
    inertia = FLYING.inertia_kgm2
    energy = 0.5 * (out[:, 10:] ** 2 @ inertia)
    spin = Rotation.from_quat(np.roll(out[:, 3:7], -1, axis=1)).apply(out[:, 10:] * inertia)
    assert np.ptp(energy) < 1e-8 * energy[0]
    assert np.abs(spin - spin[0]).max() < 1e-7 * np.linalg.norm(spin[0])


def test_linear_drag_takes_speed_exponentially() -> None:
    t = np.linspace(0.0, 0.8, 41)[None]
    out = move(FLYING, HiddenInBox(drag=1.6), t, start([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]))[0]
    assert out[:, 7] == pytest.approx(np.exp(-2.0 * t[0]), abs=1e-9)


def test_sliding_box_stops_where_friction_says_and_stays() -> None:
    t = np.linspace(0.0, 1.0, 501)[None]
    out = move(SLIDING, HiddenInBox(), t, start([1.2, 0.5, 0.0], [0.0, 0.0, 0.0]))[0]
    assert np.linalg.norm(out[-1, :2]) == pytest.approx(1.3**2 / (2.0 * 0.4 * GRAVITY), rel=1e-3)
    assert np.all(out[-50:, 7:9] == 0.0)


def test_mass_centre_off_the_origin_moves_on_the_parabola() -> None:
    t = np.linspace(0.0, 0.5, 26)[None]
    out = move(FLYING, HiddenInBox(com=(0.02, 0.0, 0.0)), t, start([0.0, 0.0, 1.0], [0.0, 5.0, 0.0]))[0]
    centre = out[:, :3] + Rotation.from_quat(np.roll(out[:, 3:7], -1, axis=1)).apply(np.tile([0.02, 0.0, 0.0], (26, 1)))
    acceleration = np.diff(centre, 2, axis=0) / np.diff(t[0])[0] ** 2
    assert acceleration == pytest.approx(np.tile([0.0, 0.0, -GRAVITY], (24, 1)), abs=1e-4)


def test_another_gravity_has_its_equals_and_its_level() -> None:
    truth = toss_case(WITH_EFFECT).truth
    assert truth.effects[0].name == "world.gravity_magnitude"
    assert {"world.constant_force", "sensor.scale", "sensor.clock_skew"} <= set(truth.accept)
    assert truth.miss == pytest.approx(6.6, rel=0.05)


def test_toss_is_read_as_written_and_holds_no_truth(tmp_path: Path) -> None:
    case = toss_case(0)
    assert case == toss_case(0)
    root = write_case(case, tmp_path)
    outcome = read(root)
    assert [d for d in outcome.diagnostics if d.severity is Severity.ERROR] == []
    text = (root / "measurement.yaml").read_text()
    assert [w for w in (*FAMILIES, "truth", "flight", "none") if w in text] == []
