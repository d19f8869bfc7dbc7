"""What is wrong with a recording is undone where the data prove it, and left alone where it may be physics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.support.bad_inputs.gap import (
    FREE,
    HINGE,
    Columns,
    columns_of,
    flight,
    folder_of,
    one_sign,
    rows,
    scaled,
    swapped,
    swing,
    tossed,
    world_rate,
)
from tests.support.measurements import assert_same_motion, codes, sound


def millimetres(columns: Columns) -> Columns:
    return scaled("px py pz vx vy vz", 1e3)(columns)


def body_velocity(columns: Columns) -> Columns:
    turn = Rotation.from_quat(np.column_stack([columns[n] for n in ("qx", "qy", "qz", "qw")]))
    return columns | columns_of("vx vy vz", turn.inv().apply(np.column_stack([columns[n] for n in ("vx", "vy", "vz")])))


@pytest.mark.parametrize(
    ("corrupt", "more", "code"),
    [
        (scaled("t", 1e3), "", "gap/time-unit"),
        (scaled("t", 1e6), "rate_hz: 100.0\n", "gap/time-unit"),
        (scaled("px py pz", 1e3), "", "gap/millimetres"),
        (scaled("vx vy vz", 1e3), "", "gap/millimetres"),
        (millimetres, "", "gap/millimetres"),
        (scaled("wx wy wz", 180.0 / np.pi), "", "gap/degrees"),
        (swapped, "", "gap/quaternion-order"),
        (world_rate, "", "gap/velocity-frame"),
        (lambda c: swapped(world_rate(c)), "", "gap/quaternion-order"),
        (body_velocity, "", "gap/velocity-frame"),
        (scaled("qw qx qy qz", 1.02), "", "gap/quaternion-not-unit"),
        (rows(lambda n: np.r_[0:30, 31, 30, 32:n]), "", "gap/time-not-increasing"),
        (rows(lambda n: np.r_[0:30, 29, 30:n]), "", "gap/time-not-increasing"),
    ],
)
def test_a_proven_mistake_is_undone_and_told(
    corrupt: Callable[[Columns], Columns], more: str, code: str, tmp_path: Path
):
    clean = sound(tossed()(tmp_path / "a"))
    folder = tossed(corrupt, more=more)(tmp_path / "b")
    assert codes(folder) == {code}
    assert_same_motion(clean, sound(folder), 2e-6)


def test_hinge_angles_in_degrees_and_wrapped_become_one_smooth_angle(tmp_path: Path):
    def spun(k: int) -> Columns:
        t = np.arange(200) / 100.0
        angle = 9.0 * t + 0.3 * np.sin(3.0 * t + k)
        return {"t": t, "angle": angle, "rate": np.gradient(angle, t)}

    def wrapped_degrees(k: int) -> Columns:
        c = spun(k)
        return c | {"angle": np.degrees(c["angle"] + np.pi) % 360.0 - 180.0, "rate": np.degrees(c["rate"])}

    clean = folder_of(tmp_path / "a", HINGE, {f"t{k}": spun(k) for k in range(4)})
    messy = folder_of(tmp_path / "b", HINGE, {f"t{k}": wrapped_degrees(k) for k in range(4)})
    assert codes(messy) == {"gap/degrees"}
    for a, b in zip(sound(clean).trials, sound(messy).trials, strict=True):
        np.testing.assert_allclose(a.q - a.q[0], b.q - b.q[0], atol=1e-6)
        np.testing.assert_allclose(a.qd, b.qd, atol=1e-6)


def test_commands_follow_the_unwrapped_angle(tmp_path: Path):
    spec = HINGE.replace("qd_hinge: rate", "command_hinge: goal")
    t = np.arange(200) / 100.0

    def driven(k: int) -> Columns:
        angle = 2.5 + 1.5 * np.sin(2.0 * t + k)
        wrap = lambda a: (a + np.pi) % (2.0 * np.pi) - np.pi  # noqa: E731
        return {"t": t, "angle": wrap(angle), "goal": wrap(angle + 0.05)}

    for trial in sound(folder_of(tmp_path, spec, {f"t{k}": driven(k) for k in range(4)})).trials:
        np.testing.assert_allclose(trial.command - trial.q, 0.05, atol=1e-6)


@pytest.mark.parametrize("factor", [0.85, 0.95, 1.05, 1.2])
def test_a_scale_that_no_unit_explains_is_left_alone(factor: float, tmp_path: Path):
    clean = sound(tossed()(tmp_path / "a"))
    folder = tossed(scaled("vx vy vz", factor))(tmp_path / "b")
    assert codes(folder) == set()
    np.testing.assert_allclose(sound(folder).trials[0].v_W, factor * clean.trials[0].v_W, rtol=1e-6, atol=1e-7)


def frames_late(names: str, rows: int) -> Callable[[Columns], Columns]:
    return lambda c: c | {n: np.concatenate([np.repeat(c[n][:1], rows), c[n][:-rows]]) for n in names.split()}


def tilted(columns: Columns) -> Columns:
    """Orientations from a tracker whose frame is turned by 10 degrees."""
    turn = Rotation.from_quat(np.column_stack([columns[n] for n in ("qx", "qy", "qz", "qw")]))
    quats = (Rotation.from_rotvec([np.radians(10.0), 0.0, 0.0]) * turn).as_quat()
    return columns | columns_of("qw qx qy qz", one_sign(np.roll(quats, 1, axis=1)))


@pytest.mark.parametrize(
    "effect",
    [
        scaled("px py pz", 1.03),
        scaled("wx wy wz", 1.15),
        scaled("t", 1.01),
        frames_late("vx vy vz wx wy wz", 2),
        frames_late("px py pz qw qx qy qz", 1),
        lambda c: c | {"wx": c["wx"] + 0.5, "pz": c["pz"] + 0.02},
        tilted,
    ],
)
def test_what_may_be_an_effect_is_not_repaired_away(effect: Callable[[Columns], Columns], tmp_path: Path):
    trial = sound(tossed(effect)(tmp_path)).trials[0]
    given = effect(flight(0))
    np.testing.assert_allclose(trial.t_s, given["t"], atol=1e-7)
    for column, names in (("p", "px py pz"), ("quat_wxyz", "qw qx qy qz"), ("v_W", "vx vy vz"), ("w_B", "wx wy wz")):
        wanted = np.column_stack([given[n] for n in names.split()])
        np.testing.assert_allclose(getattr(trial, column), wanted, atol=1e-6, err_msg=column)


def test_a_braking_slider_does_not_fall_sideways(tmp_path: Path):
    t = np.arange(60) / 100.0
    still = flight(0) | {n: np.zeros(60) for n in ("wx", "wy", "wz", "py", "pz", "vy", "vz", "qx", "qy", "qz")}
    tables = {}
    for k in range(4):
        speed = np.maximum((4.0 + 0.1 * k) - 8.0 * t, 0.0)
        tables[f"t{k}"] = still | {"qw": np.ones(60), "vx": speed, "px": np.cumsum(speed) / 100.0}
    assert codes(folder_of(tmp_path, FREE, tables)) == set()


def test_late_stamps_are_evened_but_true_irregular_sampling_stays(tmp_path: Path):
    late = np.random.default_rng(0).uniform(0.0, 0.003, (4, 60))
    stamped = tossed(lambda c: c | {"t": c["t"] + late[0]})(tmp_path / "a")
    assert codes(stamped) == {"gap/stamp-jitter"}
    steps = np.diff(sound(stamped).trials[0].t_s)
    assert np.ptp(steps) < 1e-9
    assert abs(steps.mean() - 0.01) < 1e-4
    sampled = folder_of(tmp_path / "b", FREE, {f"t{k}": flight(k, late_s=late[k]) for k in range(4)})
    assert codes(sampled) == set()
    assert np.ptp(np.diff(sound(sampled).trials[0].t_s)) > 1e-3


def test_stamps_later_than_the_next_row_keep_the_order_of_rows(tmp_path: Path):
    late = np.random.default_rng(1).uniform(0.0, 0.02, 60)
    clean = sound(tossed()(tmp_path / "a"))
    folder = tossed(lambda c: c | {"t": c["t"] + late})(tmp_path / "b")
    assert codes(folder) == {"gap/stamp-jitter"}
    for a, b in zip(clean.trials, sound(folder).trials, strict=True):
        np.testing.assert_allclose(a.p, b.p, atol=1e-9)
        np.testing.assert_allclose(a.t_s, b.t_s, atol=0.03)


def test_a_spike_is_dropped_and_an_impact_is_not(tmp_path: Path):
    def bounce(columns: Columns) -> Columns:
        hit = columns["t"] >= 0.3
        after = columns["t"] - 0.3
        return columns | {
            "pz": columns["pz"] + np.where(hit, 4.0 * after, 0.0),
            "vz": columns["vz"] + np.where(hit, 4.0, 0.0),
        }

    assert codes(tossed(bounce)(tmp_path / "a")) == set()
    spiked = sound(tossed(lambda c: c | {"py": c["py"] + 0.4 * (np.arange(60) == 33)})(tmp_path / "b"))
    assert [(len(t), t.dropped) for t in spiked.trials] == [(59, 1)] * 4
    fast = sound(tossed(lambda c: c | {"wy": c["wy"] + 300.0 * (np.arange(60) == 12)})(tmp_path / "c"))
    assert [(len(t), t.dropped) for t in fast.trials] == [(59, 1)] * 4


@settings(max_examples=20, deadline=None)
@given(yaw=st.floats(-3.1, 3.1), shift=st.integers(0, 12), cut=st.integers(0, 12), x=st.floats(-2.0, 2.0))
def test_copies_are_found_whatever_their_heading_place_and_cut(
    yaw: float, shift: int, cut: int, x: float, tmp_path_factory: pytest.TempPathFactory
):
    a = flight(0)
    turn = Rotation.from_rotvec([0.0, 0.0, yaw])
    body = Rotation.from_quat(np.column_stack([a[n] for n in ("qx", "qy", "qz", "qw")]))
    quats = one_sign(np.roll((turn * body).as_quat(), 1, axis=1))
    turned = {
        f"{v}{axis}": values
        for v in "pv"
        for axis, values in zip("xyz", turn.apply(np.column_stack([a[f"{v}{c}"] for c in "xyz"])).T, strict=True)
    }
    b = a | turned | columns_of("qw qx qy qz", quats)
    b["px"] = b["px"] + x
    b = {n: v[shift : len(v) - cut] for n, v in b.items()}
    folder = tmp_path_factory.mktemp("copies")
    folder_of(folder, FREE, {"t0": a, "t1": flight(1), "t2": flight(2), "t3": b, "t4": flight(4)})
    assert sound(folder).trial_ids == ("t0", "t1", "t2", "t4")


def test_repeated_experiments_are_no_copies(tmp_path: Path):
    """The same toss by a perfect thrower: noise differs, everything else is equal."""
    exact = flight(0, noise=False)
    rng = np.random.default_rng(5)
    again = [{n: v + (rng.normal(0.0, 2e-5, 60) if n[0] == "p" else 0.0) for n, v in exact.items()} for _ in range(4)]
    swings = {f"t{k}": swing(0) | {"angle": swing(0)["angle"] + rng.normal(0.0, 1e-4, 200)} for k in range(4)}
    assert len(sound(folder_of(tmp_path / "a", FREE, {f"t{k}": c for k, c in enumerate(again)})).trials) == 4
    assert len(sound(folder_of(tmp_path / "b", HINGE, swings)).trials) == 4


@pytest.mark.parametrize("sigma", [1e-5, 1e-3])
def test_estimated_noise_is_the_noise(sigma: float, tmp_path: Path):
    rng = np.random.default_rng(3)
    exact = [flight(k, 200, noise=False) for k in range(4)]
    tables = {
        f"t{k}": {n: v + (rng.normal(0.0, sigma, 200) if n[0] == "p" else 0.0) for n, v in c.items()}
        for k, c in enumerate(exact)
    }
    noise = sound(folder_of(tmp_path, FREE, tables)).noise
    assert noise.p_m == pytest.approx(sigma, rel=0.1)


def test_an_encoder_is_as_noisy_as_its_counts(tmp_path: Path):
    count = 2.0 * np.pi / 4096
    tables = {f"t{k}": (c := swing(k)) | {"angle": np.round(c["angle"] / count) * count} for k in range(4)}
    noise = sound(folder_of(tmp_path, HINGE, tables)).noise
    assert noise.q == pytest.approx(count / np.sqrt(12.0), rel=0.35)


def test_declared_noise_stands(tmp_path: Path):
    folder = tossed(more="sensor_noise: {p_m: 0.0007, rotation_deg: 1.0}\n")(tmp_path)
    assert sound(folder).noise.p_m == 0.0007
    assert sound(folder).noise.rotation_rad == pytest.approx(np.radians(1.0))
