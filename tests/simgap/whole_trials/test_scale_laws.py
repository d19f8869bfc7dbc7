"""Laws of scale and rate: the answer does not depend on units, on the epoch, on names or order, or on the row rate.

A slide of mass M moves under logged forces; its true damping is larger than declared. Masses, lengths and times are
multiplied by factors, which multiplies what the log holds and what the finder must find.
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
    """Factors of mass, length and time; rows per row of the plain log, epoch (s), order and names of the trials."""

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0
    rows: float = 1.0
    epoch_s: float = 0.0
    order: tuple[int, ...] = tuple(range(TRIALS))
    prefix: str = "trial"
    joint: str = "slide"
    hidden: float = HIDDEN


def recorded(law: Law, folder: Path) -> Path:
    """The measurement as a folder. Motion is integrated at fine steps (RK4) under forces held from row to row."""
    rows = round(SPAN_S * RATE_HZ * law.rows) + 1
    t_s = np.arange(rows) / (RATE_HZ * law.rows)
    rng = np.random.default_rng(5)
    phases, tones = rng.uniform(0.0, 6.0, (TRIALS, 3)), rng.uniform(1.0, 9.0, (TRIALS, 3))
    force = (np.sin(tones[:, None] * t_s[None, :, None] + phases[:, None]) * np.array([2.0, 1.5, 1.0])).sum(axis=2)
    noise = np.random.default_rng(6).normal(scale=NOISE_M, size=force.shape)
    x, v = np.zeros(TRIALS), rng.normal(scale=0.3, size=TRIALS)
    h, damping = 1.0 / (RATE_HZ * law.rows * FINE), DAMPING + law.hidden
    q = [x]
    for k in range(rows - 1):
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
    (folder / "trajectories").mkdir(parents=True)
    newton = law.mass * law.length / law.time**2
    for place in law.order:
        table = np.stack(
            [
                t_s * law.time + law.epoch_s,
                (np.array(q)[:, place] + noise[place]) * law.length,
                force[place] * newton,
            ],
            axis=1,
        )
        head = f"t,q_{law.joint},effort_{law.joint}"
        np.savetxt(
            folder / "trajectories" / f"{law.prefix}{law.order.index(place):02d}.csv",
            table, fmt="%.17g", delimiter=",", header=head, comments="",
        )  # fmt: skip
    spec = {
        "schema_version": 1,
        "name": "slide",
        "kind": "mechanism",
        "description": "a slide under logged forces",
        "columns": {"t": "t", **{f"{c}_{law.joint}": f"{c}_{law.joint}" for c in ("q", "effort")}},
        "subject": {
            "joints": [
                {
                    "name": law.joint,
                    "type": "prismatic",
                    "mass_kg": MASS_KG * law.mass,
                    "damping": DAMPING * law.mass / law.time,
                    "friction": 0.0,
                }
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
    "forces times 1000": Law(mass=1000.0),
    "lengths times 10": Law(length=10.0),
    "time times 10": Law(time=10.0),
    "twice the rows": Law(rows=2.0),
    "trials shuffled and renamed": Law(order=(4, 2, 8, 0, 7, 1, 6, 3, 5), prefix="take", joint="axis_7"),
    "another epoch": Law(epoch_s=1.7e9),
}


LONG = ("trials shuffled and renamed", "another epoch")  # in `make test-long`


@pytest.mark.parametrize(
    "law", [pytest.param(law, id=name, marks=pytest.mark.long if name in LONG else ()) for name, law in LAWS.items()]
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
