"""Convention checks from the reader's findings, and by experiments that any engine must pass; relative errors.

No check reads an engine's settings back: bodies are pushed, dropped and slid, and numbers are read off the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape
from schemas.sim_gap.report import ConventionCheck
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyRollout, BodyWindows
from sim.dynamics.hooks import BodyState, BodyWrench, Params
from sim.dynamics.mechanism import Drive, Law, MechanismModel, Windows
from sim.dynamics.tree import mass_matrix
from simgap.inference.losses import trial_losses
from simgap.problem import Problem
from simgap.recording.read import Measurement

JointReplay = Callable[[MechanismModel, Windows, Sequence[Law]], tuple[FloatArray, FloatArray]]
ENGINE_TOLERANCE = 0.02  # relative error up to which an engine holds what it was given
COEFFICIENT = 0.03  # absolute, of friction
CONVERGED = 0.05  # relative change of the error under steps four times smaller
_STEP_TRIALS = 4


@dataclass(frozen=True)
class _Read:
    """A convention that the reader checks, and the findings that mean it was repaired or is only suspected."""

    name: str
    fixed: tuple[str, ...]
    suspect: tuple[str, ...]
    fine: str


_READ = (
    _Read("time_unit", ("gap/time-unit", "gap/clock-restarts"), ("gap/rate-mismatch",), "stamps fit the declared rate"),
    _Read(
        "sampling",
        ("gap/stamp-jitter", "gap/time-not-increasing", "gap/duplicate-trials"),
        ("gap/dropped-frames",),
        "stamps increase evenly; no trial is a copy of another",
    ),
    _Read(
        "length_and_angle_units",
        ("gap/degrees", "gap/millimetres", "gap/angle-wrapped"),
        ("gap/degrees-suspected", "gap/millimetres-suspected"),
        "slopes and rates agree in metres and radians",
    ),
    _Read(
        "quaternion_order",
        ("gap/quaternion-order", "gap/quaternion-sign", "gap/quaternion-not-unit"),
        (),
        "unit quaternions, real part first",
    ),
    _Read(
        "velocity_frame",
        ("gap/velocity-frame",),
        ("gap/velocity-inconsistent", "gap/velocity-age"),
        "velocities agree with the change of the poses",
    ),
    _Read("gravity_axis", (), ("gap/gravity-axis",), "nothing falls along another axis"),
)
_OF_POSES = ("quaternion_order", "gravity_axis")


def reader_checks(measurement: Measurement, findings: Sequence[Diagnostic]) -> tuple[ConventionCheck, ...]:
    """Convention checks from the findings of reading and checking a folder."""
    checks = []
    for check in _READ:
        if check.name in _OF_POSES and measurement.spec.kind == "mechanism":
            continue
        matching = [d for d in findings if d.code in (*check.fixed, *check.suspect)]
        suspect = any(d.code in check.suspect for d in matching)
        evidence = "; ".join(dict.fromkeys(d.headline for d in matching)) or check.fine
        checks.append(
            ConventionCheck(
                name=check.name, status="suspect" if suspect else "fixed" if matching else "ok", evidence=evidence
            )
        )
    return tuple(checks)


def rate_frame_check(measurement: Measurement) -> ConventionCheck | None:
    """Whether measured angular velocities, taken in body axes, agree with the change of orientation; None without."""
    errors = [e for t in measurement.trials if t.has("w_B") for e in [_rate_errors(t.t_s, t.quat_wxyz, t.w_B)]]
    if not errors:
        return None
    body, world = np.median(np.array(errors), axis=0)
    evidence = f"orientation changes leave {body:.2g} rad/s with rates in body axes, {world:.2g} in world axes"
    return ConventionCheck(
        name="angular_velocity_frame", status="ok" if body <= world else "suspect", evidence=evidence
    )


def _rate_errors(t_s: FloatArray, quat_wxyz: FloatArray, w_B: FloatArray) -> tuple[float, float]:
    """Root mean square difference between turning rates and orientation changes, rates read in body and world axes."""
    R = Rotation.from_quat(np.roll(quat_wxyz, -1, axis=1))
    span = np.diff(t_s)[:, None]
    middle = 0.5 * (w_B[1:] + w_B[:-1])
    in_body = (R[:-1].inv() * R[1:]).as_rotvec() / span
    in_world = (R[1:] * R[:-1].inv()).as_rotvec() / span
    of_body, of_world = (float(np.sqrt(np.nanmean(((d - middle) ** 2).sum(axis=1)))) for d in (in_body, in_world))
    return of_body, of_world


def step_size_check(problem: Problem, finer: Problem, trials: Sequence[str]) -> ConventionCheck:
    """How much the error of the declared model changes under steps four times smaller (`finer`), on a few trials."""
    few = tuple(trials)[:_STEP_TRIALS]
    scale = np.maximum(problem.noise_floor(few, "short_horizon"), 1e-12)
    before, after = (float(trial_losses(p.residuals((), few, "short_horizon"), scale).mean()) for p in (problem, finer))
    change = abs(after - before) / max(before, 1e-12)
    evidence = f"steps four times smaller change the error by {change:.1%}"
    return ConventionCheck(name="step_size", status="ok" if change < CONVERGED else "suspect", evidence=evidence)


def body_engine_checks(engine: BodyRollout, model: BodyModel) -> tuple[ConventionCheck, ...]:
    """Whether an engine holds the numbers of a free body: mass, inertia, gravity, no damping, friction."""
    checks = [_mass(engine, model), _inertia(engine, model), _damping(engine, model), _gravity(engine, model)]
    if model.has_support:
        checks.append(_friction(engine, model))
    return tuple(checks)


def joint_engine_checks(engine: JointReplay, model: MechanismModel) -> tuple[ConventionCheck, ...]:
    """Whether an engine holds the inertia of joints and leaves them alone: no motor, no damping of its own."""
    n = len(model.tree)
    bare = replace(model, gravity_W=np.zeros(3), friction=np.zeros(n), damping=np.zeros(n), drive=Drive(), limits=None)
    t = np.linspace(0.0, 0.5, 51)
    worst_rate, worst_inertia = 0.0, 0.0
    for j in range(n):
        rate = np.zeros((1, n))
        rate[0, j] = 0.1
        # One joint alone turns: the others may follow, so the energy is compared, which no free joint loses.
        q, qd = engine(bare, Windows(t[None], np.zeros((1, n)), rate), ())
        energy = [float(v @ mass_matrix(bare.tree, p[None])[0] @ v) for p, v in zip(q[0], qd[0], strict=True)]
        worst_rate = max(worst_rate, abs(energy[-1] / energy[0] - 1.0))
        M = mass_matrix(bare.tree, np.zeros((1, n)))[0]
        effort = np.zeros((1, len(t), n))
        effort[..., :] = M[:, j] * 0.1
        pushed = replace(bare, drive=Drive(type="effort", kp=np.zeros(n), kd=np.zeros(n)))
        _, qd = engine(pushed, Windows(t[None, :6], np.zeros((1, n)), np.zeros((1, n)), effort=effort[:, :6]), ())
        worst_inertia = max(worst_inertia, abs(qd[0, -1, j] / (0.1 * t[5]) - 1.0))
    return (
        held("joint_motor_and_damping_off", worst_rate, "energy that a free joint loses or gains in 0.5 s"),
        held("joint_inertia_held", worst_inertia, "error of the acceleration under a known effort"),
    )


def held(name: str, error: float, what: str, bound: float = ENGINE_TOLERANCE) -> ConventionCheck:
    """A check that passes when a relative error stays below its bound."""
    return ConventionCheck(name=name, status="ok" if error < bound else "suspect", evidence=f"{what}: {error:.2%}")


def _flying(model: BodyModel) -> BodyModel:
    return replace(model, gravity_W=np.zeros(3), has_support=False)


def _flight(
    engine: BodyRollout,
    model: BodyModel,
    span_s: float,
    v_W: FloatArray,
    w_B: FloatArray,
    push: tuple[FloatArray, FloatArray] | None = None,
) -> BodyMotion:
    """Motion from the origin, axes along the world's, under a constant force and torque."""
    t = np.linspace(0.0, span_s, 25)[None]
    start = BodyWindows(t, np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]), v_W[None], w_B[None])

    def wrench(state: BodyState, params: Params) -> tuple[FloatArray, FloatArray]:
        force, torque = push or (np.zeros(3), np.zeros(3))
        return force[None], torque[None]

    return engine.rollout(model, start, [(BodyWrench(wrench), {})] if push else [])


def _mass(engine: BodyRollout, model: BodyModel) -> ConventionCheck:
    force = np.array([model.mass_kg, 0.0, 0.0])
    motion = _flight(engine, _flying(model), 0.1, np.zeros(3), np.zeros(3), (force, np.zeros(3)))
    return held("mass_held", abs(motion.v_W[0, -1, 0] / 0.1 - 1.0), "error of the acceleration under a known force")


def _inertia(engine: BodyRollout, model: BodyModel) -> ConventionCheck:
    """The inertia from the spin that a torque about each axis gives, small enough that axes hardly turn."""
    spins = []
    for axis in np.eye(3):
        torque = 0.1 * axis * float(model.inertia_B.diagonal() @ axis)
        motion = _flight(engine, _flying(model), 0.1, np.zeros(3), np.zeros(3), (np.zeros(3), torque))
        spins.append(motion.w_B[0, -1] / 0.1 / (torque @ axis))
    seen = np.linalg.inv(np.array(spins).T)
    error = float(np.abs(seen - model.inertia_B).max() / np.abs(model.inertia_B).max())
    return held("inertia_held", error, "error of the inertia seen in the engine against the declared one")


def _damping(engine: BodyRollout, model: BodyModel) -> ConventionCheck:
    spin = np.linalg.eigh(model.inertia_B)[1][:, 2] * 5.0
    motion = _flight(engine, replace(_flying(model), com_B=np.zeros(3)), 1.0, np.array([1.0, 0.0, 0.0]), spin)
    lost = max(1.0 - np.linalg.norm(motion.v_W[0, -1]), 1.0 - np.linalg.norm(motion.w_B[0, -1]) / 5.0)
    return held("damping_off", abs(float(lost)), "speed lost in 1 s of free flight without drag", 1e-3)


def _gravity(engine: BodyRollout, model: BodyModel) -> ConventionCheck:
    motion = _flight(engine, replace(model, has_support=False), 0.2, np.zeros(3), np.zeros(3))
    error = np.linalg.norm(motion.v_W[0, -1] / 0.2 - model.gravity_W) / max(np.linalg.norm(model.gravity_W), 1e-9)
    return held("gravity_held", float(error), "error of the acceleration in free fall")


def _friction(engine: BodyRollout, model: BodyModel) -> ConventionCheck:
    """The pair's friction from a flat plate that slides."""
    mu, g = (model.friction or 0.3), GRAVITY_MPS2
    size = (0.2, 0.2, 0.02)
    plate = _probe(CollisionShape("box", size, np.eye(4)), np.diag([0.0034, 0.0034, 0.0067]), mu)
    t = np.linspace(0.0, 0.5 / (mu * g), 13)[None]
    start = BodyWindows(
        t, np.array([[0.0, 0.0, 0.01]]), np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 3))
    )
    v = engine.rollout(plate, start).v_W[0, :, 0]
    seen = float((v[3] - v[-1]) / (t[0, -1] - t[0, 3]) / g)
    status = "ok" if abs(seen - mu) < COEFFICIENT else "suspect"
    return ConventionCheck(
        name="friction_of_pair", status=status, evidence=f"asked {mu:.3g}, a sliding plate shows {seen:.3g}"
    )


def _probe(shape: CollisionShape, inertia: FloatArray, friction: float) -> BodyModel:
    return BodyModel((shape,), 1.0, np.zeros(3), inertia, friction=friction, restitution=0.0)
