"""Laws of scale and rate: the answer does not depend on units, on the epoch, on names or order, or on the row rate.

A slide of mass M moves under logged forces; its true damping is larger than declared. Masses, lengths and times are
multiplied by factors, which multiplies what the log holds and what the finder must find. Slides beside it, where a law
has them, hide nothing.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cli.engines import REPLAY_ENGINE
from schemas.sim_gap.report import GapReport
from simgap.case import case_of
from simgap.find_gap import find_effects
from simgap.recording.read import read

MASS_KG, DAMPING, HIDDEN, SPAN_S, RATE_HZ, NOISE_M = 1.4, 0.8, 0.5, 2.0, 80.0, 2e-4
TRIALS, FINE = 9, 10


@dataclass(frozen=True)
class Law:
    """Factors of mass, length and time; rows per row of the plain log, epoch (s), order and names of the trials.

    joints    in their order in the log; the first by name hides the effect.
    """

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0
    rows: float = 1.0
    epoch_s: float = 0.0
    order: tuple[int, ...] = tuple(range(TRIALS))
    prefix: str = "trial"
    joints: tuple[str, ...] = ("slide",)
    hidden: float = HIDDEN


def _moved(t_s: np.ndarray, rate_hz: float, hidden: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, forces and noise, (trials, rows) each, of one slide whose damping is larger by `hidden`."""
    rng = np.random.default_rng(seed)
    phases, tones = rng.uniform(0.0, 6.0, (TRIALS, 3)), rng.uniform(1.0, 9.0, (TRIALS, 3))
    force = (np.sin(tones[:, None] * t_s[None, :, None] + phases[:, None]) * np.array([2.0, 1.5, 1.0])).sum(axis=2)
    noise = np.random.default_rng(seed + 1).normal(scale=NOISE_M, size=force.shape)
    x, v = np.zeros(TRIALS), rng.normal(scale=0.3, size=TRIALS)
    h, damping = 1.0 / (rate_hz * FINE), DAMPING + hidden
    q = [x]
    for k in range(len(t_s) - 1):
        for _ in range(FINE):

            def pull(rate: np.ndarray, k: int = k) -> np.ndarray:
                return (force[:, k] - damping * rate) / MASS_KG

            a = pull(v)
            b = pull(v + 0.5 * h * a)
            c = pull(v + 0.5 * h * b)
            d = pull(v + h * c)
            x = x + h * v + h * h * (a + b + c) / 6.0
            v = v + h * (a + 2.0 * b + 2.0 * c + d) / 6.0
        q.append(x)
    return np.array(q).T, force, noise


def recorded(law: Law, folder: Path) -> Path:
    """The measurement as a folder. Motion is integrated at fine steps (RK4) under forces held from row to row."""
    rows = round(SPAN_S * RATE_HZ * law.rows) + 1
    t_s = np.arange(rows) / (RATE_HZ * law.rows)
    newton = law.mass * law.length / law.time**2
    columns: dict[str, np.ndarray] = {}
    for number, joint in enumerate(sorted(law.joints)):
        q, force, noise = _moved(t_s, RATE_HZ * law.rows, law.hidden if number == 0 else 0.0, 5 + 2 * number)
        columns[f"q_{joint}"] = (q + noise) * law.length
        columns[f"effort_{joint}"] = force * newton
    names = [f"{c}_{joint}" for joint in law.joints for c in ("q", "effort")]
    (folder / "trajectories").mkdir(parents=True)
    for place in law.order:
        table = np.stack([t_s * law.time + law.epoch_s, *(columns[n][place] for n in names)], axis=1)
        np.savetxt(
            folder / "trajectories" / f"{law.prefix}{law.order.index(place):02d}.csv",
            table, fmt="%.17g", delimiter=",", header=",".join(["t", *names]), comments="",
        )  # fmt: skip
    spec = {
        "schema_version": 1,
        "name": "slide",
        "kind": "mechanism",
        "description": "a slide under logged forces",
        "columns": {"t": "t", **{name: name for name in names}},
        "subject": {
            "joints": [
                {
                    "name": joint,
                    "type": "prismatic",
                    "mass_kg": MASS_KG * law.mass,
                    "damping": DAMPING * law.mass / law.time,
                    "friction": 0.0,
                }
                for joint in law.joints
            ]
        },
        "actuation": {"type": "effort"},
        "world": {"gravity_mps2": [0, 0, -9.81 * law.length / law.time**2]},
    }
    (folder / "measurement.yaml").write_text(json.dumps(spec))
    return folder


@cache
def answered(law: Law, folder: Path) -> GapReport:
    measurement = read(recorded(law, folder)).value
    assert measurement is not None
    case = case_of(measurement, REPLAY_ENGINE)
    return find_effects(case.problem, case.trials, measurement="m", horizon_s=case.problem.horizon_s, quick=True).report


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> GapReport:
    return answered(Law(), tmp_path_factory.mktemp("plain") / "m")


LAWS = {
    "forces times 1000, lengths and time times 10": Law(mass=1000.0, length=10.0, time=10.0),
    "forces times 1000": Law(mass=1000.0),
    "lengths times 10": Law(length=10.0),
    "time times 10": Law(time=10.0),
    "twice the rows": Law(rows=2.0),
    "four times the rows": Law(rows=4.0),
    "trials shuffled and renamed": Law(order=(4, 2, 8, 0, 7, 1, 6, 3, 5), prefix="take", joints=("axis_7",)),
    "another epoch": Law(epoch_s=1.7e9),
}


PLAIN = (
    "forces times 1000, lengths and time times 10",
    "four times the rows",
)  # in `make test`, the others in the long


@pytest.mark.parametrize(
    "law", [pytest.param(law, id=name, marks=() if name in PLAIN else pytest.mark.long) for name, law in LAWS.items()]
)
def test_the_answer_follows_the_scale(law: Law, plain: GapReport, tmp_path: Path) -> None:
    report = answered(law, tmp_path / "m")
    assert report.verdict.status == plain.verdict.status == "effect_found"
    (effect,), (expected,) = report.verdict.effects, plain.verdict.effects
    assert effect.name == expected.name == "joint.viscous_friction"
    value, before = (next(iter(e.parameters.values())) for e in (effect, expected))
    factor = law.mass / law.time
    truth = (DAMPING + law.hidden) * factor
    assert value.ci95[0] - 0.01 * truth <= truth <= value.ci95[1] + 0.01 * truth
    assert value.value / factor == pytest.approx(before.value, rel=0.01)


def test_four_times_the_time_and_no_cause_need_no_effect(tmp_path: Path) -> None:
    for number, law in enumerate((Law(hidden=0.0), Law(hidden=0.0, mass=1e-3, length=0.1, time=4.0))):
        assert answered(replace(law), tmp_path / str(number)).verdict.status == "no_effect"


@pytest.mark.long
def test_joints_may_come_in_any_order(tmp_path: Path) -> None:
    named = []
    for number, joints in enumerate((("a", "b"), ("b", "a"))):
        report = answered(Law(joints=joints), tmp_path / str(number))
        assert report.verdict.status == "effect_found"
        (effect,) = report.verdict.effects
        assert (effect.name, effect.where.joint) == ("joint.viscous_friction", "a")
        named.append(effect)
    values = [next(iter(effect.parameters.values())).value for effect in named]
    assert values[1] == pytest.approx(values[0], rel=1e-3)
    assert named[1].confidence == pytest.approx(named[0].confidence, abs=0.02)
