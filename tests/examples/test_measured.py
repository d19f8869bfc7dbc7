"""Public recordings through their converters: sound on arrival, and their known traps are seen."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.gap.reading import tosses
from examples.measured import emps, panda_exciting, planar_push
from examples.measured.folder import Part, in_blocks, packed, write
from schemas.diagnostics import Diagnostic, Severity
from schemas.measurement import MeasurementSpec
from simgap.recording.read import Measurement, read
from tests.support.present import present

NAMES = (
    "cube_toss",
    "elbow_toss",
    "servo_xl330",
    "servo_sts3250",
    "emps",
    "pendulum",
    "ellipse_impact",
    "planar_push",
    "panda_exciting",
)
EXPECTED = {  # warnings that the recordings deserve
    "servo_sts3250": {"gap/dropped-frames", "gap/too-few-trials"},
    "pendulum": {"gap/too-few-trials"},  # three segments of the single pendulum
    "ellipse_impact": {"gap/duplicate-trials"},  # the source lists events twice
    "panda_exciting": {"gap/dropped-frames"},
}


def parts_of(shared: Path, name: str) -> Sequence[Part]:
    return importlib.import_module(f"examples.measured.{name}").parts(shared / name)


def at_most(part: Part, tables: int) -> Part:
    """The part with its first tables only; the split then names trials that are gone, so it goes too."""
    spec = {key: value for key, value in part.spec.items() if key != "split"}
    return part._replace(spec=spec, tables=dict(list(part.tables.items())[:tables]))


def warned(diagnostics: Sequence[Diagnostic]) -> set[str]:
    return {d.code for d in diagnostics if d.severity in (Severity.WARNING, Severity.ERROR)}


def converted(folder: Path, part: Part) -> Measurement:
    write(folder, part)
    outcome = read(folder)
    assert outcome.value is not None, [d.headline for d in outcome.diagnostics]
    return outcome.value


@pytest.mark.shared
@pytest.mark.parametrize("name", NAMES)
def test_converted_recordings_are_sound(name: str, shared_measured: Path, tmp_path: Path):
    for part in parts_of(shared_measured, name)[:3]:
        write(tmp_path / (part.name or name), at_most(part, 60) if len(part.tables) > 100 else part)
        outcome = read(tmp_path / (part.name or name))
        assert outcome.value is not None, [d.headline for d in outcome.diagnostics]
        assert warned(outcome.diagnostics) <= EXPECTED.get(name, set())


@pytest.mark.shared
def test_velocities_of_tosses_are_half_a_frame_old_and_in_body_axes(shared_measured: Path, tmp_path: Path):
    part = at_most(parts_of(shared_measured, "cube_toss")[0], 60)
    clean = converted(tmp_path / "a", part)
    ages = {d.headline.split("'")[1]: d.value for d in read(tmp_path / "a").diagnostics if d.code == "gap/velocity-age"}
    assert ages == {"v": 0.5, "w": 0.5}
    columns = {("w_world" if key == "w_body" else key): value for key, value in part.spec["columns"].items()}
    wrong = converted(tmp_path / "b", part._replace(spec={**part.spec, "columns": columns}))
    assert warned(read(tmp_path / "b").diagnostics) == {"gap/velocity-frame"}
    np.testing.assert_allclose(wrong.trials[0].w_B, clean.trials[0].w_B, atol=1e-6)


@pytest.mark.shared
def test_noise_of_tosses_is_what_others_measured(shared_measured: Path, tmp_path: Path):
    """0.02 mm, 4 mm/s and 0.04 rad/s, from an independent look at the data."""
    noise = converted(tmp_path, at_most(parts_of(shared_measured, "cube_toss")[0], 100)).noise
    assert noise.p_m == pytest.approx(2e-5, rel=0.5)
    assert noise.v_mps == pytest.approx(4e-3, rel=0.5)
    assert noise.w_radps == pytest.approx(4e-2, rel=0.5)


@pytest.mark.shared
def test_turned_copies_of_real_tosses_are_found_and_no_others(shared_measured: Path, tmp_path: Path):
    part = at_most(parts_of(shared_measured, "cube_toss")[0], 80)
    ids = list(part.tables)
    copies = {f"{i}_again": turned(dict(part.tables[i]), 0.3 * (k + 1)) for k, i in enumerate(ids[::10])}
    both = converted(tmp_path, part._replace(tables={**part.tables, **copies}))
    assert set(both.trial_ids) == set(ids)


def turned(columns: dict[str, np.ndarray], yaw_rad: float) -> dict[str, np.ndarray]:
    """The toss as seen by a camera that stands elsewhere, rounded as the files are."""
    turn = Rotation.from_rotvec([0.0, 0.0, yaw_rad])
    quats = (turn * Rotation.from_quat(np.column_stack([columns[n] for n in ("qx", "qy", "qz", "qw")]))).as_quat()
    p, v = (turn.apply(np.column_stack([columns[f"{s}{axis}"] for axis in "xyz"])) for s in "pv")
    moved = dict(zip(("px", "py", "pz", "vx", "vy", "vz"), np.column_stack([p, v]).T, strict=True))
    moved |= dict(zip(("qx", "qy", "qz", "qw"), quats.T, strict=True))
    return {**columns, **{n: values.astype(np.float32).astype(np.float64) for n, values in moved.items()}}


@pytest.mark.shared
def test_hinge_angles_come_without_jumps(shared_measured: Path, tmp_path: Path):
    measurement = converted(tmp_path, at_most(parts_of(shared_measured, "elbow_toss")[0], 80))
    assert measurement.joints == ("elbow",)
    assert max(np.abs(np.diff(t.q, axis=0)).max() for t in measurement.trials) < 2.0
    raw = [rows[:, 7] for _, rows in packed(shared_measured / "elbow_toss" / "tosses.npz")]
    assert max(np.abs(np.diff(q)).max() for q in raw) > 6.0


@pytest.mark.shared
def test_drive_force_explains_the_axis_motion(shared_measured: Path, tmp_path: Path):
    """Force, acceleration and the published mass belong together: least squares on them gives the mass back."""
    measurement = converted(tmp_path, emps.parts(shared_measured / "emps")[0])
    rows = []
    for trial in measurement.trials:
        t, q, effort = trial.t_s, trial.q[:, 0], trial.effort[:, 0]
        rate = np.gradient(np.convolve(q, np.ones(25) / 25, "same"), t)
        acceleration = np.gradient(np.convolve(rate, np.ones(25) / 25, "same"), t)
        force = measurement.spec.actuation.effort_per_unit * effort
        rows.append(np.column_stack([acceleration, rate, np.sign(rate) * (np.abs(rate) > 0.01), force])[60:-60])
    data = np.concatenate(rows)
    mass, viscous, coulomb = np.linalg.lstsq(data[:, :3], data[:, 3], rcond=None)[0]
    assert mass == pytest.approx(95.1, rel=0.1)
    assert viscous == pytest.approx(203.5, rel=0.15)
    assert coulomb == pytest.approx(20.4, rel=0.2)


@pytest.mark.shared
def test_pushing_force_points_along_the_push(shared_measured: Path, tmp_path: Path):
    parts = planar_push.parts(shared_measured / "planar_push")
    measurement = converted(tmp_path, next(p for p in parts if p.name == "wood_patch"))
    agree = []
    for push in measurement.pushes:
        contact = np.linalg.norm(push.force, axis=1) > 1.0
        force = push.force[contact].mean(axis=0)
        path = (push.tip_p[-1] - push.tip_p[0])[:2]
        agree.append(force @ path / np.linalg.norm(force) / np.linalg.norm(path))
    assert min(agree) > 0.5
    assert np.median(agree) > 0.9


@pytest.mark.shared
def test_540_tosses_are_read_whole(shared_measured: Path, tmp_path: Path):
    """What it costs: `benchmarks.gap.reading`."""
    part = tosses(shared_measured)
    write(tmp_path, part)
    found = read(tmp_path).value
    assert found is not None
    assert sorted(trial.id for trial in found.trials) == sorted(part.tables)


def test_blocks_keep_neighbours_on_one_side():
    ids = [f"s{k:02d}" for k in range(12)]
    split = in_blocks(ids)
    assert sorted(split["train"] + split["test"]) == ids
    sides = ["train" if i in split["train"] else "test" for i in ids]
    assert sum(a != b for a, b in pairwise(sides)) == 3
    assert in_blocks(["a", "b"]) == {"train": ["a"], "test": ["b"]}


def test_arm_model_has_seven_joints_and_the_published_reach():
    """The flange of the stretched arm stands 0.333 + 0.316 + 0.384 m up, and 0.088 m out."""
    from lxml import etree

    robot = etree.fromstring(panda_exciting.urdf().encode())
    X = np.eye(4)
    for joint in robot.findall("joint"):
        origin = present(joint.find("origin"))
        step = np.eye(4)
        step[:3, :3] = Rotation.from_euler("x", float(origin.get("rpy", "").split()[0])).as_matrix()
        step[:3, 3] = [float(v) for v in origin.get("xyz", "").split()]
        X = X @ step
    assert len(robot.findall("joint")) == 7
    np.testing.assert_allclose(X[:3, 3], [0.088, 0.0, 1.033], atol=1e-9)


def test_what_is_written_is_what_the_reader_takes(tmp_path: Path):
    t = np.arange(50) / 100.0
    tables = {f"s{k}": {"t": t, "x": np.sin(3.0 * t + k)} for k in range(4)}
    spec = {
        "schema_version": 1,
        "name": "slide",
        "kind": "mechanism",
        "columns": {"t": "t", "q_slide": "x"},
        "subject": {"joints": [{"name": "slide", "type": "prismatic", "mass_kg": 2.0}]},
    }
    measurement = converted(tmp_path / "m", Part("", spec, tables))
    assert measurement.spec == MeasurementSpec.model_validate(spec)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").write_text("years of work")
    with pytest.raises(FileExistsError):
        write(tmp_path / "other", Part("", spec, tables))
