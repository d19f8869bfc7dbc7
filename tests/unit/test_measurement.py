"""Reading a measurement: formats agree, repairs undo what corrupted the data, sound data are left alone."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from schemas.diagnostics import Severity
from simgap.measurement import Measurement, read
from tests.gap_bad_inputs import (
    FREE,
    HINGE,
    Columns,
    columns_of,
    csv,
    flight,
    folder_of,
    one_sign,
    pushed,
    pushes,
    rows,
    scaled,
    struck,
    swapped,
    swing,
    swung,
    tossed,
    world_rate,
)

STATE = ("t_s", "p", "quat_wxyz", "v_W", "w_B")


def sound(folder: Path) -> Measurement:
    outcome = read(folder)
    assert outcome.value is not None, [d.headline for d in outcome.diagnostics]
    return outcome.value


def codes(folder: Path, least: Severity = Severity.WARNING) -> set[str]:
    wanted = {Severity.ERROR, Severity.WARNING} if least is Severity.WARNING else set(Severity)
    return {d.code for d in read(folder).diagnostics if d.severity in wanted}


def assert_same_motion(a: Measurement, b: Measurement, tolerance: float = 1e-6) -> None:
    assert a.trial_ids == b.trial_ids
    for s, t in zip(a.trials, b.trials, strict=True):
        for name in STATE:
            np.testing.assert_allclose(getattr(s, name), getattr(t, name), atol=tolerance, err_msg=name)


@pytest.mark.parametrize("write", [tossed(), swung(), struck(), pushes()])
def test_sound_data_bring_no_warning(write: Callable[[Path], Path], tmp_path: Path):
    assert codes(write(tmp_path)) == set()


def test_columns_arrive_under_our_names(tmp_path: Path):
    trial, given = sound(tossed()(tmp_path)).trials[1], flight(1)
    np.testing.assert_allclose(trial.p, np.column_stack([given[n] for n in ("px", "py", "pz")]), rtol=1e-8)
    np.testing.assert_allclose(trial.quat_wxyz[:, 0], given["qw"], rtol=1e-7)
    assert trial.q.shape == (60, 0)
    assert not trial.has("effort")
    assert trial.has("w_B")


def as_npz(path: Path, columns: Columns) -> None:
    vectors = {"p": "px py pz", "q": "qw qx qy qz", "v": "vx vy vz", "w": "wx wy wz"}
    stacked = {k: np.column_stack([columns[n] for n in names.split()]) for k, names in vectors.items()}
    np.savez(path, t=columns["t"], **stacked)


def test_csv_parquet_and_npz_hold_the_same_trial(tmp_path: Path):
    text = sound(tossed()(tmp_path / "csv"))
    for kind in ("parquet", "npz"):
        folder = tmp_path / kind
        spec = (
            FREE
            if kind == "parquet"
            else FREE.split("columns")[0]
            + ("columns: {t: t, p: p, q_wxyz: q, v: v, w_body: w}\n" + FREE.partition("w_body: [wx, wy, wz]}\n")[2])
        )
        folder_of(folder, spec, {})
        for k in range(4):
            path = folder / "trajectories" / f"t{k}.{kind}"
            pq.write_table(pa.table(flight(k)), path) if kind == "parquet" else as_npz(path, flight(k))
        assert_same_motion(text, sound(folder), 1e-7)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace(",", ";"),
        lambda text: text.replace(",", "\t"),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: "# logged on a Tuesday\n\n" + text,
        lambda text: text.replace(",", ", "),
    ],
)
def test_spreadsheet_dialects_read_alike(change: Callable[[str], str], tmp_path: Path):
    plain = sound(tossed()(tmp_path / "a"))
    folder = tossed()(tmp_path / "b")
    for path in (folder / "trajectories").iterdir():
        path.write_bytes(change(path.read_text()).encode())
    assert_same_motion(plain, sound(folder), 0.0)


def xyzw(columns: Columns) -> Columns:
    return swapped(columns)


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


def test_declared_order_and_frame_are_obeyed(tmp_path: Path):
    clean = sound(tossed()(tmp_path / "a"))
    spec = FREE.replace("q_wxyz: [qw, qx, qy, qz]", "q_xyzw: [qx, qy, qz, qw]").replace("w_body", "w_world")
    folder = tossed(world_rate, spec)(tmp_path / "b")
    assert codes(folder) == set()
    assert_same_motion(clean, sound(folder), 1e-6)


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


def test_commands_follow_the_unwrapped_angle(tmp_path: Path):
    spec = HINGE.replace("qd_hinge: rate", "command_hinge: goal")
    t = np.arange(200) / 100.0

    def driven(k: int) -> Columns:
        angle = 2.5 + 1.5 * np.sin(2.0 * t + k)
        wrap = lambda a: (a + np.pi) % (2.0 * np.pi) - np.pi  # noqa: E731
        return {"t": t, "angle": wrap(angle), "goal": wrap(angle + 0.05)}

    for trial in sound(folder_of(tmp_path, spec, {f"t{k}": driven(k) for k in range(4)})).trials:
        np.testing.assert_allclose(trial.command - trial.q, 0.05, atol=1e-6)


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


ARM = """\
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="finger"/><link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/></joint>
  <joint name="slide" type="prismatic"><parent link="lower"/><child link="finger"/></joint>
  <joint name="flange" type="fixed"><parent link="lower"/><child link="tip"/></joint>
</robot>
"""
TRACKING = """\
schema_version: 1
name: arm
kind: tracking
rate_hz: 100
columns: {q_elbow: e, q_shoulder: s, command_elbow: ce, command_shoulder: cs, p: [x, y, z], q_wxyz: [qw, qx, qy, qz]}
subject: {urdf: arm.urdf, end_effector: tip, controller: {type: stable_pd, kp: 100, kd: 10}}
"""


def test_tracked_joints_come_in_the_order_of_the_model(tmp_path: Path):
    t = np.arange(100) / 100.0
    pose = columns_of("x y z", np.zeros((100, 3))) | columns_of("qw qx qy qz", np.tile([1.0, 0.0, 0.0, 0.0], (100, 1)))
    moves = {"e": np.sin(t), "s": np.cos(t), "ce": np.sin(t) + 0.1, "cs": np.cos(t) + 0.1}
    folder = folder_of(tmp_path, TRACKING, {f"t{k}": moves | pose | {"e": np.sin(t + k)} for k in range(4)})
    (folder / "arm.urdf").write_text(ARM)
    measurement = sound(folder)
    assert measurement.joints == ("shoulder", "elbow")  # the slide is in the model, but nobody measured it
    np.testing.assert_allclose(measurement.trials[0].q, np.column_stack([np.cos(t), np.sin(t)]), atol=1e-8)
    assert measurement.trials[0].has("command")
    assert not measurement.trials[0].has("command_p")


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


def test_the_hash_follows_content_and_not_place(tmp_path: Path):
    first = tossed()(tmp_path / "a")
    shutil.copytree(first, tmp_path / "b")
    assert sound(first).content_hash == sound(tmp_path / "b").content_hash
    table = tmp_path / "b" / "trajectories" / "t2.csv"
    table.write_text(table.read_text().replace("1", "2", 1))
    assert sound(first).content_hash != sound(tmp_path / "b").content_hash


def test_trials_come_in_natural_order_and_numbers_are_ids(tmp_path: Path):
    folder = folder_of(
        tmp_path,
        FREE + "split: {train: [2, 007], test: [10]}\n",
        {n: flight(k) for k, n in enumerate(["10", "2", "007"])},
    )
    assert sound(folder).trial_ids == ("2", "007", "10")
    assert sound(folder).spec.split is not None


def test_sound_trials_survive_a_broken_one(tmp_path: Path):
    folder = tossed(trials=5)(tmp_path)
    (folder / "trajectories" / "t2.csv").write_bytes(b"\xff\xfe\x00garbage")
    assert sound(folder).trial_ids == ("t0", "t1", "t3", "t4")
    assert codes(folder) == {"gap/unreadable-table"}


def test_impacts_and_pushes_become_arrays(tmp_path: Path):
    impacts = sound(struck()(tmp_path / "a")).impacts
    assert impacts is not None
    assert impacts.normal.shape == (50, 3)
    assert np.isnan(impacts.pose_before).all()
    first = sound(pushes()(tmp_path / "b")).pushes[0]
    assert first.tip_p.shape == (30, 3)
    assert first.force.shape == (60, 2)
    np.testing.assert_allclose(first.after_p - first.before_p, [0.02, 0.0, 0.0])


def test_a_push_may_be_one_npz(tmp_path: Path):
    spec = pushes()(tmp_path / "a") / "measurement.yaml"
    head, _, tail = spec.read_text().partition("columns:")
    columns = "columns: {p: p, q_wxyz: q, tip_t: tip_t, tip_p: tip, force_t: force_t, force: force}\n"
    folder = folder_of(tmp_path / "b", head + columns + tail.partition("\n")[2], {})
    for k in range(4):
        pose, tip, force = (pushed(k)[part] for part in ("pose", "tip", "force"))
        np.savez(
            folder / "trajectories" / f"p{k}.npz",
            p=np.column_stack([pose[n] for n in "xyz"]),
            q=np.column_stack([pose[n] for n in ("qw", "qx", "qy", "qz")]),
            tip_t=tip["t"],
            tip=np.column_stack([tip[n] for n in "xyz"]),
            force_t=force["t"],
            force=np.column_stack([force["fx"], force["fy"]]),
        )
    for a, b in zip(sound(tmp_path / "a").pushes, sound(folder).pushes, strict=True):
        np.testing.assert_allclose(a.tip_p, b.tip_p, atol=1e-8)
        np.testing.assert_allclose(a.force_t_s, b.force_t_s, atol=1e-8)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_no_file_content_raises(data: st.DataObject, tmp_path_factory: pytest.TempPathFactory):
    """Whatever stands in the folder, the answer is an outcome."""
    folder = tmp_path_factory.mktemp("fuzz")
    tossed(trials=2)(folder)
    spec = (folder / "measurement.yaml").read_text()
    at = data.draw(st.integers(0, len(spec)))
    junk = data.draw(st.text("{}[]:,-&*!|>'\"\n\t 0a.é", max_size=6))
    (folder / "measurement.yaml").write_text(spec[:at] + junk + spec[at + data.draw(st.integers(0, 8)) :])
    path = folder / "trajectories" / data.draw(st.sampled_from(["t0.csv", "t0.npz", "t0.parquet"]))
    text = csv(flight(0, rows=8)).encode()
    cut = data.draw(st.integers(0, len(text)))
    path.write_bytes(data.draw(st.one_of(st.binary(max_size=40), st.just(text[:cut] + b"nan,inf,x,\n" + text[cut:]))))
    outcome = read(folder)
    assert outcome.value is not None or any(d.severity is Severity.ERROR for d in outcome.diagnostics)
