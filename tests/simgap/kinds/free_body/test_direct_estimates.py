"""Direct estimates against motions whose law is written down here: parabolas, impulses, steady sliding, rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.stats import norm

from schemas.physics import CollisionShape
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.kinds.free_body.candidates import absent, candidates_of, with_direct_bounds
from simgap.kinds.free_body.direct_estimates import estimate, pooled
from simgap.kinds.free_body.normal_equations import NormalEquations
from simgap.kinds.free_body.toss import Toss
from simgap.problem import DirectEstimate

G, EDGE, MASS, ROW_S = 9.81, 0.1, 0.4, 1.0 / 150.0
INERTIA = MASS * EDGE**2 / 6.0
CUBE = BodyModel(
    shapes=(CollisionShape("box", (EDGE,) * 3, np.eye(4)),),
    mass_kg=MASS,
    com_B=np.zeros(3),
    inertia_B=INERTIA * np.eye(3),
)
RNG = np.random.default_rng(5)


def _toss(t, p, R: Rotation, v=None, w_B=None, body: BodyModel = CUBE) -> Toss:
    noisy = p + RNG.normal(0.0, 2e-5, p.shape)
    turned = R * Rotation.from_rotvec(RNG.normal(0.0, 2e-4, p.shape))
    columns = {"p": noisy, "quat_wxyz": np.roll(turned.as_quat(), 1, axis=1)}
    columns["v_W"] = np.gradient(p, t, axis=0) if v is None else v
    columns["w_B"] = np.zeros_like(p) if w_B is None else w_B
    return Toss(AppliedBody(body, (), ()), Series(t, columns))


def _estimate_or_none(name: str, tosses: list[Toss]) -> DirectEstimate | None:
    series = [toss.series for toss in tosses]
    return estimate(next(c for c in candidates_of(CUBE, series) if c.effect.name == name), tosses)


def _estimated(name: str, tosses: list[Toss]) -> DirectEstimate:
    estimate = _estimate_or_none(name, tosses)
    assert estimate is not None
    return estimate


def _flight(acceleration, com=(0.0, 0.0, 0.0), drag: float = 0.0):
    """Stamps, origin, orientation and velocity of a spinning body thrown from 1 m."""
    t = np.arange(40) * ROW_S
    v0 = np.array([*RNG.uniform(-2.0, 2.0, 2), RNG.uniform(0.5, 2.0)])
    spin = RNG.normal(0.0, 8.0, 3)
    R = Rotation.from_rotvec(t[:, None] * spin) * Rotation.from_quat(RNG.normal(size=4))

    def law(_t, y):
        v = y[3:]
        return [*v, *(acceleration - drag / MASS * np.linalg.norm(v) * v)]

    path = solve_ivp(law, (0.0, t[-1]), [0.0, 0.0, 1.0, *v0], t_eval=t, rtol=1e-10, atol=1e-12).y.T
    return t, path[:, :3] - R.apply(np.asarray(com)), R, path[:, 3:]


@pytest.mark.parametrize(
    ("name", "acceleration", "expected"),
    [
        ("world.gravity_magnitude", (0.0, 0.0, -9.4), {"gravity_mps2": 9.4}),
        ("world.constant_force", (0.3, -0.2, -G), {"x_N": 0.12, "y_N": -0.08, "z_N": 0.0}),
        ("world.gravity_tilt", (-G * 0.05, 0.0, -G), {"about_x_rad": 0.0, "about_y_rad": 0.05}),
        ("sensor.scale", (0.0, 0.0, -0.95 * G), {"factor": 0.95}),
        ("sensor.clock_skew", (0.0, 0.0, -G / 1.05**2), {"factor": 1.05}),
    ],
)
def test_a_parabola_gives_the_pull(name, acceleration, expected):
    found = _estimated(name, [_toss(*_flight(np.array(acceleration))[:3]) for _ in range(8)])
    for parameter, value in expected.items():
        assert found.values[parameter] == pytest.approx(value, abs=4.0 * found.standard_errors[parameter] + 2e-3)
    assert found.p_value < 1e-4
    assert found.trials == 8


def test_drag_is_what_changes_with_speed_whatever_the_pull():
    down = np.array([0.0, 0.0, -9.5])
    with_drag = _estimated("world.quadratic_drag", [_toss(*_flight(down, drag=0.05)[:3]) for _ in range(10)])
    without = _estimated("world.quadratic_drag", [_toss(*_flight(down)[:3]) for _ in range(10)])
    assert with_drag.values["drag_Ns2pm2"] == pytest.approx(0.05, rel=0.1)
    assert abs(without.values["drag_Ns2pm2"]) < 5e-3


def test_the_mass_centre_is_the_point_that_does_not_wobble():
    com = (0.01, -0.004, 0.002)
    found = _estimated("body.com_offset", [_toss(*_flight(np.array([0.0, 0.0, -G]), com)[:3]) for _ in range(8)])
    assert list(found.values.values()) == pytest.approx(com, abs=5e-4)


def test_old_velocities_show_their_age():
    made = [_flight(np.array([0.0, 0.0, -G])) for _ in range(6)]
    late = [_toss(t, p, R, v + np.array([0.0, 0.0, G * 0.004])) for t, p, R, v in made]
    assert _estimated("sensor.velocity_age", late).values["age_s"] == pytest.approx(0.004, abs=3e-4)


def _bounce(restitution: float, mu: float, inertia: float):
    """A cube that meets the floor with one corner: Newton's restitution, Coulomb's friction at its limit."""
    corner_down = Rotation.align_vectors([[0.0, 0.0, -1.0]], [np.ones(3) / np.sqrt(3.0)])[0]
    R0 = Rotation.from_rotvec(RNG.normal(0.0, 0.15, 3)) * corner_down
    lever = R0.apply(np.ones(3) * EDGE / 2.0)
    v, w = np.array([1.5, RNG.uniform(-0.3, 0.3), -1.5]), RNG.normal(0.0, 1.0, 3)
    slip = v + np.cross(w, lever)
    push = np.array([*(-mu * slip[:2] / np.linalg.norm(slip[:2])), 1.0])
    response = push / MASS + np.cross(np.cross(lever, push) / inertia, lever)
    strength = -(1.0 + restitution) * slip[2] / response[2]
    after_v, after_w = v + strength * push / MASS, w + strength * np.cross(lever, push) / inertia
    t = (np.arange(24) - 11.5) * ROW_S
    late = t[:, None] > 0.0
    fall = np.array([0.0, 0.0, -G])
    p = np.array([0.0, 0.0, -lever[2]]) + t[:, None] * np.where(late, after_v, v) + 0.5 * t[:, None] ** 2 * fall
    return t - t[0], p, Rotation.from_rotvec(t[:, None] * np.where(late, after_w, w)) * R0


def test_impulses_give_bounce_friction_and_inertia():
    tosses = [_toss(*_bounce(0.6, 0.1, 1.5 * INERTIA)) for _ in range(12)]
    assert _estimated("contact.restitution", tosses).values["restitution"] == pytest.approx(0.6, abs=0.08)
    assert _estimated("body.inertia", tosses).values["factor"] == pytest.approx(1.5, rel=0.08)
    assert _estimated("contact.friction", tosses).values["mu"] == pytest.approx(0.1, abs=0.01)


def _sliding(mu: float, height: float = EDGE / 2.0, tilted: float = 0.0):
    t = np.arange(70) * ROW_S
    speed, heading = 1.2, RNG.uniform(0.0, 2.0 * np.pi)
    moving = np.minimum(t, speed / (mu * G))
    along = speed * moving - 0.5 * mu * G * moving**2
    p = np.stack([along * np.cos(heading), along * np.sin(heading), np.full(len(t), height)], axis=1)
    R = Rotation.from_euler("z", RNG.uniform(0.0, 6.0)) * Rotation.from_rotvec([tilted, 0.0, 0.0])
    return t, p, Rotation.concatenate([R] * len(t))


def test_deceleration_gives_friction():
    assert _estimated("contact.friction", [_toss(*_sliding(0.35)) for _ in range(6)]).values["mu"] == pytest.approx(
        0.35, abs=0.02
    )


def test_the_height_at_rest_gives_the_size_and_its_tilt_the_mounting():
    low = _estimated("body.size", [_toss(*_sliding(0.5, 0.96 * EDGE / 2.0)) for _ in range(6)])
    assert low.values["factor"] == pytest.approx(0.96, abs=1e-3)
    on_faces = []
    for face in range(12):
        t, p, R = _sliding(0.5)
        turn = Rotation.from_euler("x", 90.0 * face, degrees=True) * Rotation.from_euler("y", 90.0 * (face % 3), True)
        on_faces.append(_toss(t, p, R * turn * Rotation.from_rotvec([0.03, 0.0, -0.02])))
    mounting = _estimated("sensor.frame_rotation", on_faces)
    assert list(mounting.values.values()) == pytest.approx([0.03, 0.0, -0.02], abs=3e-3)


def test_a_scale_that_falls_and_heights_do_not_share_is_not_sure():
    flights = [_toss(*_flight(np.array([0.0, 0.0, -0.95 * G]))[:3]) for _ in range(6)]
    rests = [_toss(*_sliding(0.5)) for _ in range(6)]
    found = _estimated("sensor.scale", flights + rests)
    for told in (0.95, 1.0):
        assert abs(found.values["factor"] - told) < 3.0 * found.standard_errors["factor"]


@pytest.mark.parametrize(("fallen", "lost"), [(1.0, "sensor.scale"), (0.95, None)])
def test_what_shrinks_at_rest_and_not_in_falls_is_no_scale(fallen: float, lost: str | None):
    flights = [_toss(*_flight(np.array([0.0, 0.0, -fallen * G]))[:3]) for _ in range(6)]
    tosses = flights + [_toss(*_sliding(0.5, 0.95 * EDGE / 2.0)) for _ in range(6)]
    tried = candidates_of(CUBE, [t.series for t in tosses], lambda candidate: estimate(candidate, tosses))
    names = {c.effect.name for c in tried}
    assert {"sensor.scale", "body.size"} - names == ({lost} - {None})


def _reading(value: float, error: float) -> DirectEstimate:
    return DirectEstimate({"factor": value}, {"factor": error}, float(2.0 * norm.sf(abs(value - 1.0) / error)), 12)


@pytest.mark.parametrize(
    ("falls", "missing"),
    [(_reading(0.996, 0.004), False), (_reading(0.999, 0.001), True), (_reading(0.97, 0.02), False)],
)
def test_a_reading_that_sees_nothing_is_enough_only_where_it_contradicts_the_other(falls, missing):
    """A real scale of 0.99 may be lost in the noise of falls, and still be there at rest."""
    wide = next(c for c in candidates_of(CUBE, [_toss(*_sliding(0.5)).series]) if c.effect.name == "sensor.scale")
    rest = _reading(0.99, 0.0005)
    assert absent(wide, replace(rest, separate_readings=(falls, rest))) == missing


@pytest.mark.parametrize(("p_value", "highest"), [(1e-6, 0.0038), (0.03, 0.0046)])
def test_fits_go_no_further_than_what_motion_tells_errs(p_value: float, highest: float):
    flight = _toss(*_flight(np.array([0.0, 0.0, -G]))[:3])
    wide = next(c for c in candidates_of(CUBE, [flight.series]) if c.effect.name == "sensor.velocity_age")
    low, high = wide.bounds["age_s"]
    held = with_direct_bounds(wide, DirectEstimate({"age_s": 0.0034}, {"age_s": 1e-4}, p_value, 12))
    span = 0.002 * (high - low)
    assert held.bounds["age_s"] == pytest.approx((max(low, -highest + 0.0034 - span), highest + span), abs=6e-5)
    assert held.direct_half_width == ({"age_s": pytest.approx(0.0004 + span, abs=6e-5)} if p_value < 0.01 else {})


def test_accepted_terms_leave_nothing_to_find():
    heavy = replace(CUBE, gravity_W=np.array([0.0, 0.0, -9.4]))
    found = _estimated("world.constant_force", [_toss(*_flight(heavy.gravity_W)[:3], body=heavy) for _ in range(8)])
    assert found.p_value > 1e-3


def test_what_was_not_seen_is_not_estimated():
    flights = [_toss(*_flight(np.array([0.0, 0.0, -G]))[:3]) for _ in range(4)]
    assert _estimate_or_none("contact.friction", flights) is None
    assert _estimate_or_none("body.size", flights) is None
    assert _estimate_or_none("contact.compliance", flights) is None


@pytest.mark.parametrize("freedom", [3, 30], ids=["some tosses far off", "nearly normal"])
def test_pooled_errors_are_those_of_repeated_experiments(freedom: int) -> None:
    """Estimates over their standard errors scatter by one (24 tosses, 400 experiments)."""
    rng, deviations = np.random.default_rng(3), []
    for _ in range(400):
        sizes, values = rng.uniform(0.5, 2.0, 24), rng.standard_t(freedom, 24)
        sets = iter(
            NormalEquations(np.array([[s]]), np.array([s * v]), np.zeros(1)) for s, v in zip(sizes, values, strict=True)
        )
        found = pooled(lambda _, sets=sets: next(sets), [None] * 24)  # pyright: ignore[reportArgumentType]
        assert found is not None
        deviations.append(float(found[0][0] / found[1][0]))
    assert np.std(deviations) == pytest.approx(1.0, abs=0.15)
    assert abs(np.mean(deviations)) < 0.15
