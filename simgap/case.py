"""A measurement made ready for the search: its problem, its trials, and the conventions that were checked.

Bodies and linkages are rolled out by an engine, which the caller names (`sim.named_engine`); mechanisms, impacts and
pushes have roll-outs of their own, and an engine only checks the conventions of mechanisms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.sim_gap.report import ConventionCheck, RolloutEngine
from sim.dynamics.body_rollout import BodyRollout
from sim.dynamics.linkage_rollout import LinkageRollout
from sim.dynamics.mechanism import MechanismModel, Windows, rollout
from sim.dynamics.tree import Tree
from sim.named_engine import load_engine
from simgap.kinds.free_body.declared_model import build_body
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.kinds.free_body.rigid import RigidBodySimulator
from simgap.kinds.impact.problem import ImpactProblem
from simgap.kinds.linkage.convention_checks import linkage_engine_checks
from simgap.kinds.linkage.declared_model import build_linkage
from simgap.kinds.linkage.tossed_body import LinkageSimulator
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.push.problem import PushProblem
from simgap.recording.read import Measurement
from simgap.recording.train_test_split import Trials, split_trials
from simgap.report.side_by_side import joint_windows
from simgap.sanity import convention_checks
from simgap.sanity.convention_checks import JointReplay

_FINER = 4.0  # the check of the step size divides steps by this
_CHECKED_HORIZONS = 5.0  # of the first trial: as far as steps are checked


class ReplayEngine(Protocol):
    """What the sim gap needs of a physics engine: replays of bodies and linkages, roll-outs of mechanisms."""

    @property
    def name(self) -> str:
        """Name and version, for people."""
        ...

    @property
    def largest_step_s(self) -> float:
        """The step at which a search rolls out bodies (s)."""
        ...

    @property
    def mechanism_rollout(self) -> JointReplay:
        """Rolls out windows of a mechanism, as `sim.dynamics.mechanism.rollout` does."""
        ...

    def mechanism_rollout_at(self, step_s: float) -> JointReplay:
        """Like `mechanism_rollout`, with steps of at most `step_s`."""
        ...

    def body_rollout(self, step_s: float) -> BodyRollout:
        """A replay of one free rigid body with steps of at most `step_s`."""
        ...

    def linkage_rollout(self, step_s: float) -> LinkageRollout:
        """A replay of a free linkage with steps of at most `step_s`."""
        ...


def replay_engine(name: str) -> ReplayEngine:
    """The engine of this name; loads it."""
    return load_engine(name)()


@dataclass(frozen=True)
class Case:
    """A measurement ready for the search, with the joints of a mechanism and the name of the engine."""

    measurement: Measurement
    problem: MechanismProblem | FreeBodyProblem | ImpactProblem | PushProblem
    trials: Trials
    joints: tuple[str, ...]
    engine: str


def case_of(measurement: Measurement, engine: str) -> Case:
    """The problem of a measurement. Raises InvalidInput for kinds, subjects and sizes that cannot be searched."""
    if measurement.spec.kind == "tracking":
        text = f"measurements of kind '{measurement.spec.kind}' are read and checked, but no search explains them yet"
        raise InvalidInput(finding("gap/kind-unsupported-yet", text, value=measurement.spec.kind))
    try:
        trials = split_trials(measurement.spec, measurement.trial_ids)
    except ValueError as few:
        raise InvalidInput(finding("gap/too-few-trials", str(few), severity=Severity.ERROR)) from None
    try:
        if measurement.spec.kind == "mechanism":
            return Case(measurement, MechanismProblem(measurement), trials, measurement.joints, engine)
        if measurement.spec.kind == "impact":
            impact = ImpactProblem(measurement, trials)
            return Case(measurement, impact, impact.trials, (), engine)
        if measurement.spec.kind == "push":
            return Case(measurement, PushProblem(measurement), trials, (), engine)
        return Case(measurement, FreeBodyProblem(measurement, simulator_of(measurement, engine)), trials, (), engine)
    except ValueError as refused:
        raise InvalidInput(finding("gap/subject-unsupported-yet", str(refused))) from None


def simulator_of(measurement: Measurement, engine: str, finer: float = 1.0) -> RigidBodySimulator | LinkageSimulator:
    """The declared body with an engine in steps so many times finer. Raises ValueError for an unsupported subject."""
    replays = replay_engine(engine)
    step_s, spec, root = replays.largest_step_s / finer, measurement.spec, measurement.root
    if measurement.joints:
        return LinkageSimulator(build_linkage(spec, root), replays.linkage_rollout(step_s))
    return RigidBodySimulator(build_body(spec, root), replays.body_rollout(step_s))


def convention_checks_of(case: Case, findings: Sequence[Diagnostic]) -> tuple[ConventionCheck, ...]:
    """All conventions that were checked, by reading and by experiment."""
    checks = list(convention_checks.reader_checks(case.measurement, findings))
    problem = case.problem
    events = problem.as_events()
    if events is not None:
        return (*checks, *events.convention_checks)  # No engine: the law is in closed form.
    mechanism = problem.declared_mechanism()
    if mechanism is not None:
        engine = replay_engine(case.engine)
        checks += convention_checks.joint_engine_checks(engine.mechanism_rollout, without_armature(mechanism))
        checks.append(_joint_step_check(case, mechanism))
        return tuple(checks)
    rate = convention_checks.rate_frame_check(case.measurement)
    checks += [rate] if rate else []
    # At small steps, so that a wrong convention is not confused with the error of a step.
    finer = simulator_of(case.measurement, case.engine, _FINER)
    if isinstance(finer, LinkageSimulator):
        checks += linkage_engine_checks(finer)
    else:
        checks += convention_checks.body_engine_checks(finer.engine, finer.declared)
    checks.append(
        convention_checks.step_size_check(problem, FreeBodyProblem(case.measurement, finer), case.trials.train)
    )
    finer.engine.close()
    return tuple(checks)


def declared_rollout(case: Case) -> RolloutEngine:
    """In which engine, and in which steps, models of this case are rolled out."""
    engine = replay_engine(case.engine)
    method = "contacts of a rigid body, in equal steps between the rows"
    step_s = case.problem.engine_time_s() * engine.largest_step_s
    return case.problem.own_rollout() or RolloutEngine(name=engine.name, method=method, step_s=step_s)


def without_armature(model: MechanismModel) -> MechanismModel:
    """The mechanism with links that a rigid-body engine can hold."""
    tree: Tree = tuple(replace(link, armature=0.0) for link in model.tree)
    return replace(model, tree=tree)


def _joint_step_check(case: Case, mechanism: MechanismModel) -> ConventionCheck:
    """Our own roll-outs at steps four times smaller, against the range of the motion, over a few radians of it."""
    applied = apply_terms(mechanism, ())
    trial = next(t for t in case.measurement.trials if t.id in case.trials.train)
    over_s, step_s = _CHECKED_HORIZONS * case.problem.horizon_s, declared_rollout(case).step_s
    assert step_s is not None
    windows = cut_windows(joint_windows(trial, applied), over_s)
    plain, fine = (rollout(applied.mechanism, windows, largest_step_s=step_s / k)[0] for k in (1.0, _FINER))
    span = max(float(np.ptp(windows.q0)), float(np.ptp(trial.q)), 1e-300)
    moved = float(np.abs(plain - fine).max()) / span
    return ConventionCheck(
        name="step_size",
        status="ok" if moved < 0.01 else "suspect",
        evidence=f"steps four times smaller move the first {over_s:.2g} s by {moved:.2%} of the range",
    )


def cut_windows(windows: Windows, span_s: float) -> Windows:
    """The first seconds of one window."""
    rows = np.s_[:, : max(2, int(np.searchsorted(windows.t_s[0], windows.t_s[0, 0] + span_s)))]
    return Windows(
        windows.t_s[rows],
        windows.q0,
        windows.qd0,
        None if windows.command is None else windows.command[rows],
        None if windows.effort is None else windows.effort[rows],
        {name: values[rows] for name, values in windows.aux.items()},
    )
