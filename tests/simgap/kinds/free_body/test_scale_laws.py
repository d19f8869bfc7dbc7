"""Laws of scale and rate for tosses: what is found does not depend on units, sizes, names, order or the rate of rows.

MuJoCo makes the motions. Masses, lengths and times are multiplied by factors, noise along with them; gravity follows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.measurement import MeasurementSpec, SensorNoise
from schemas.sim_gap.report import GapReport
from sim.bullet.body import BulletBodyRollout
from simgap.find_gap import find_effects
from simgap.kinds.free_body.declared_model import build_body
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.kinds.free_body.rates import body_rates, rows_of_slopes, slope_noise_per_s, velocities
from simgap.kinds.free_body.rigid import RigidBodySimulator
from simgap.problem import Candidate
from simgap.recording.read import Measurement
from simgap.recording.train_test_split import split_trials
from tests.suites.gap.free_body_cases import measured, spec_of
from tests.suites.gap.free_body_truth import Box, toss

TRIALS, MU, HIDDEN_MU, STEP_S = 12, 0.4, 0.12, 2.5e-4
EDGES_M = np.array([0.11, 0.08, 0.095])


@dataclass(frozen=True)
class Law:
    """Factors of mass, length and time; rows per second; order and names of the trials; whether rates are columns."""

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0
    rate_hz: float = 120.0
    order: tuple[int, ...] = tuple(range(TRIALS))
    prefix: str = "t"
    has_rates: bool = True


@cache
def recorded(rate_hz: float) -> Measurement:
    """Boxes more slippery than declared, tossed onto a floor; the same motions at every rate."""
    box = Box(EDGES_M, float(800.0 * EDGES_M.prod()), MU)
    tosses = [toss(box, {"mu": HIDDEN_MU}, np.random.default_rng(k), 1.0, STEP_S, 1.0 / rate_hz) for k in range(TRIALS)]
    return measured(spec_of(box), tosses)


def problem_of(law: Law) -> FreeBodyProblem:
    plain = recorded(law.rate_hz)
    speed, spin = law.length / law.time, 1.0 / law.time
    trials = []
    for number, place in enumerate(law.order):
        t = plain.trials[place]
        trials.append(
            replace(
                t,
                id=f"{law.prefix}{number:02d}",
                t_s=t.t_s * law.time,
                p=t.p * law.length,
                v_W=t.v_W * (speed if law.has_rates else np.nan),
                w_B=t.w_B * (spin if law.has_rates else np.nan),
            )
        )
    noise = SensorNoise(
        p_m=5e-5 * law.length,
        rotation_rad=5e-4,
        v_mps=4e-3 * speed if law.has_rates else None,
        w_radps=0.04 * spin if law.has_rates else None,
    )
    measurement = Measurement(_scaled(plain.spec, law), tuple(trials), Path("."), "tosses", (), noise)
    return FreeBodyProblem(
        measurement, RigidBodySimulator(build_body(measurement.spec, Path(".")), BulletBodyRollout())
    )


def _scaled(spec: MeasurementSpec, law: Law) -> MeasurementSpec:
    document = spec.model_dump(mode="json", exclude_unset=True)
    subject, world = document["subject"], document["world"]
    subject["box"]["size_m"] = [law.length * v for v in subject["box"]["size_m"]]
    subject["mass_kg"] *= law.mass
    subject["inertia_kgm2"] = [law.mass * law.length**2 * v for v in subject["inertia_kgm2"]]
    world["gravity_mps2"] = [law.length / law.time**2 * v for v in world["gravity_mps2"]]
    return MeasurementSpec.model_validate(document)


# Powers of two: whole roll-outs through contacts amplify what other factors round.
SCALES = {
    "forces times 1024": Law(mass=1024.0),
    "16 times longer under the same gravity": Law(length=16.0, time=4.0),
    "a sixteenth as long, a 1024th as heavy": Law(length=1.0 / 16.0, time=0.25, mass=1.0 / 1024.0),
    "time times 8": Law(time=8.0),
}


def _unit(law: Law, unit: str) -> float:
    """Factor of a unit under the law; a unit that is not here fails the test."""
    m, le, t = law.mass, law.length, law.time
    units = {
        "1": 1.0,
        "rad": 1.0,
        "m": le,
        "s": t,
        "kg": m,
        "N": m * le / t**2,
        "N/m": m / t**2,
        "N s/m": m / t,
        "N s2/m2": m / le,
        "m/s2": le / t**2,
    }
    return units[unit]


@cache
def plain_problem() -> FreeBodyProblem:
    return problem_of(Law())


@pytest.mark.parametrize("law", [pytest.param(law, id=name) for name, law in SCALES.items()])
def test_roll_outs_floors_bounds_and_direct_estimates_scale(law: Law) -> None:
    plain, problem = plain_problem(), problem_of(law)
    by_channel = np.array([law.length] * 3 + [1.0] * 3)
    assert problem.horizon_s == pytest.approx(law.time * plain.horizon_s)
    for ours, before in zip(
        problem.residuals((), problem.trial_ids[:4], "short_horizon"),
        plain.residuals((), plain.trial_ids[:4], "short_horizon"),
        strict=True,
    ):
        np.testing.assert_allclose(ours / by_channel, before, rtol=1e-4, atol=1e-7)
    floors = [p.noise_floor(p.trial_ids, "short_horizon") for p in (problem, plain)]
    np.testing.assert_allclose(floors[0] / by_channel, floors[1], rtol=1e-3)
    candidates = [[*p.candidates(), *p.nuisances()] for p in (problem, plain)]
    assert [c.effect.name for c in candidates[0]] == [c.effect.name for c in candidates[1]]
    for ours, before in zip(*candidates, strict=True):
        _same_numbers(law, ours, before)
        direct = [p.direct(c, (), p.trial_ids) for p, c in ((problem, ours), (plain, before))]
        assert (direct[0] is None) == (direct[1] is None)
        if direct[0] is not None and direct[1] is not None:
            assert direct[0].trials == direct[1].trials
            for parameter in ours.effect.parameters:
                factor = _unit(law, parameter.unit)
                error = factor * direct[1].standard_errors[parameter.name]
                expected = factor * direct[1].values[parameter.name]
                assert direct[0].values[parameter.name] == pytest.approx(expected, rel=1e-4, abs=0.01 * error)
                assert direct[0].standard_errors[parameter.name] == pytest.approx(error, rel=0.01)


def _same_numbers(law: Law, ours: Candidate, before: Candidate) -> None:
    for parameter in ours.effect.parameters:
        factor, name = _unit(law, parameter.unit), parameter.name
        for a, b in ((ours.null, before.null), (ours.start, before.start)):
            assert a[name] == pytest.approx(factor * b[name], rel=1e-3), (ours.effect.name, name)
        assert ours.bounds[name] == pytest.approx([factor * v for v in before.bounds[name]], rel=1e-3, abs=1e-12), (
            ours.effect.name,
            name,
        )


def answered(law: Law) -> GapReport:
    problem = problem_of(law)
    trials = split_trials(problem.measurement.spec, problem.trial_ids)
    return find_effects(problem, trials, measurement="m", horizon_s=problem.horizon_s, quick=True).report


def _named(law: Law) -> dict[str, float]:
    """First parameter of every effect that is named with a confidence of at least 0.8."""
    report = answered(law)
    assert report.verdict.status == "effect_found"
    return {e.name: next(iter(e.parameters.values())).value for e in report.verdict.effects if e.confidence >= 0.8}


RATES = {
    "120 Hz": Law(),
    "240 Hz": Law(rate_hz=240.0),
    "500 Hz": Law(rate_hz=500.0),
    "500 Hz, poses alone": Law(rate_hz=500.0, has_rates=False),
}


@pytest.mark.long
@pytest.mark.parametrize("law", [pytest.param(law, id=name) for name, law in RATES.items()])
def test_the_same_tosses_keep_the_name_of_their_friction_at_every_rate(law: Law) -> None:
    assert _named(law) == {"contact.friction": pytest.approx(HIDDEN_MU, abs=0.04)}


@pytest.mark.long
def test_the_answer_follows_scale_order_and_names() -> None:
    plain = _named(Law())
    for law in (
        Law(length=10.0, time=10.0**0.5),
        Law(mass=1000.0, time=10.0),
        Law(order=(7, 2, 11, 0, 4, 9, 1, 10, 3, 8, 6, 5), prefix="take"),
    ):
        assert _named(law) == {name: pytest.approx(value, rel=0.1) for name, value in plain.items()}


@pytest.mark.parametrize("rate_hz", [60.0, 150.0, 1000.0])
def test_rates_from_poses_are_exact_on_steady_turns_and_falls(rate_hz: float) -> None:
    rows = rows_of_slopes(0.1, 1.0 / rate_hz)
    t_s = np.arange(40) / rate_hz
    spin, v0, g = np.array([1.0, -2.0, 3.0]), np.array([1.0, 0.0, 2.0]), np.array([0.0, 0.0, -9.81])
    quats = _turned(np.array([0.3, -0.2, 0.9]), t_s[:, None] * spin)
    np.testing.assert_allclose(body_rates(t_s, quats, rows), np.tile(spin, (40, 1)), rtol=1e-6)
    inner = slice(rows // 2, 40 - rows // 2)
    p = t_s[:, None] * v0 + 0.5 * t_s[:, None] ** 2 * g
    np.testing.assert_allclose(velocities(t_s, p, rows)[inner], (v0 + t_s[:, None] * g)[inner], atol=1e-9)


def test_faster_rows_give_quieter_rates() -> None:
    noises = []
    for rate_hz in (150.0, 600.0, 2400.0):
        rows, t_s = rows_of_slopes(0.1, 1.0 / rate_hz), np.arange(4000) / rate_hz
        noise = velocities(t_s, np.random.default_rng(0).normal(size=(4000, 3)), rows)[rows:-rows].std()
        assert noise == pytest.approx(slope_noise_per_s(rows, 1.0 / rate_hz), rel=0.05)
        noises.append(noise)
    assert noises[0] > 1.3 * noises[1] > 2.0 * noises[2]


def _turned(start: np.ndarray, by: np.ndarray) -> np.ndarray:
    return np.roll((Rotation.from_rotvec(start) * Rotation.from_rotvec(by)).as_quat(), 1, axis=1)
