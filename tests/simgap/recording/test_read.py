"""Reading a measurement: formats and dialects agree, columns arrive under our names, nothing makes it fall over."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import jsonschema
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from schemas.diagnostics import Severity
from schemas.measurement import MeasurementSpec
from simgap.recording.read import read
from simgap.recording.reading.spec import read_spec
from simgap.recording.reading.yaml_text import parse_yaml
from tests.support.bad_inputs.gap import (
    FREE,
    Columns,
    columns_of,
    csv,
    flight,
    folder_of,
    pushed,
    pushes,
    struck,
    swung,
    tossed,
    world_rate,
)
from tests.support.measurements import assert_same_motion, codes, sound


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
    np.savez(path, t=columns["t"], **stacked, allow_pickle=True)


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


def test_declared_order_and_frame_are_obeyed(tmp_path: Path):
    clean = sound(tossed()(tmp_path / "a"))
    spec = FREE.replace("q_wxyz: [qw, qx, qy, qz]", "q_xyzw: [qx, qy, qz, qw]").replace("w_body", "w_world")
    folder = tossed(world_rate, spec)(tmp_path / "b")
    assert codes(folder) == set()
    assert_same_motion(clean, sound(folder), 1e-6)


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


EVERY_KEY = """\
schema_version: 1
name: door
kind: mechanism
description: a door on two hinges
rate_hz: 148.0
columns: {t: t, q_hinge: angle, effort_hinge: push, command_hinge: goal}
aux: {supply_V: input_volts, temperature_C: temp}
sensor_noise: {q: 0.0005, rotation_deg: 0.3}
subject:
  joints:
    - {name: hinge, type: revolute, inertia_kgm2: 0.4, limits_deg: [0, 95], damping: 0.1, friction: 1e-2,
       gravity_load: {mass_kg: 3, com_distance_m: 0.02, zero_deg: 90}}
  contact: {friction: 0.5, restitution: 0.0}
world:
  gravity_mps2: [0, 0, -9.81]
  support: {plane: {normal: [0, 0, 1], height_m: 0.0}}
actuation: {type: position_pd, kp: 5, kd: [0.1], effort_limit: 2.0, effort_per_unit: 1.0}
split: {train: [a, b], test: [c]}
"""


def test_published_schema_and_reader_take_the_same_file():
    document = parse_yaml(EVERY_KEY.encode(), "measurement.yaml")
    jsonschema.validate(document.value, MeasurementSpec.model_json_schema())
    spec, found = read_spec(document)
    assert found == ()
    assert spec is not None
    joint = spec.subject.joints[0]
    assert joint.limits == pytest.approx((0.0, np.radians(95.0)))
    assert joint.gravity_load is not None
    assert joint.gravity_load.zero_rad == pytest.approx(np.pi / 2.0)
    assert joint.friction == 0.01
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**document.value, "subjet": {}}, MeasurementSpec.model_json_schema())
