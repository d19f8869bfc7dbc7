"""Figures of the exercise of one joint against the bounds of the policy: checks for the record, and findings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.acceptance.joints.policy import POLICY
from geom.convex.placement import moved_shape
from geom.convex.support_function import diagonal
from geom.pose import pose
from schemas.acceptance import Check
from schemas.arrays import FloatArray
from schemas.articulation import JointContact
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.mechanism import MechanismJoint
from schemas.physics import RigidBody
from sim.joint_exercise import Actuation, JointExercise, JointRun, LinkOverlap

NOT_FINITE = float(np.finfo(np.float32).max)  # stands for figures that are not finite


@dataclass(frozen=True)
class JudgedJoint:
    """The checks of one joint, the findings on those that failed, and whether a person should look."""

    checks: tuple[Check, ...]
    diagnostics: tuple[Diagnostic, ...]
    review: bool = False


@dataclass(frozen=True)
class JointSubject:
    """One joint under judgement: as the package has it, as it was declared, and what came of its exercise.

    `in_loop`: it belongs to a loop, whose closing joint the exercise leaves out; other links are in its way then.
    `at_rest` are the overlaps of links at rest.
    """

    joint: MechanismJoint
    declared: MechanismJoint
    exercise: JointExercise
    at_rest: Sequence[LinkOverlap]
    in_loop: bool

    @property
    def unit(self) -> str:
        """Unit of positions."""
        return "rad" if self.joint.is_angular else "m"

    def tolerance(self, share: float) -> float:
        """A share of the range, at least the finest tolerance of a position."""
        low, high = self.exercise.reach
        return max(share * (high - low), POLICY.least_angle if self.joint.is_angular else POLICY.least_length)

    def runs(self, actuation: Actuation) -> list[JointRun]:
        """The runs of one kind."""
        return [run for run in self.exercise.runs if run.actuation == actuation]

    def check(self, figure: str, value: float, bound: float, unit: str) -> Check:
        """A check named `joint.<name>.<figure>` that passes up to the bound."""
        value = value if np.isfinite(value) else NOT_FINITE
        name = f"joint.{self.joint.name}.{figure}"
        return Check(name=name, value=float(value), bound=float(bound), unit=unit, passed=bool(value <= bound))

    def finding(self, code: str, headline: str, check: Check) -> Diagnostic:
        """A finding on a failed check."""
        where = self.joint.where or Location(prim=self.joint.name)
        text = f"joint '{self.joint.source_name or self.joint.name}' {headline}"
        return finding(code, text, where=where, value=check.value, bound=check.bound, unit=check.unit)


def judge_joint(subject: JointSubject) -> JudgedJoint:
    """All checks of one joint but those of its contact."""
    if not all(run.finite for run in subject.exercise.runs):
        return _unstable(subject, NOT_FINITE)
    parts = [_speeds(subject), _reach(subject), _range(subject), _overrun(subject), _axis(subject), _return(subject)]
    parts += [_penetration(subject), _probe(subject)]
    return joined(parts)


def joined(parts: Sequence[JudgedJoint]) -> JudgedJoint:
    """All of several judgements."""
    return JudgedJoint(
        tuple(check for part in parts for check in part.checks),
        tuple(d for part in parts for d in part.diagnostics),
        any(part.review for part in parts),
    )


def judge_contact(
    joint: MechanismJoint, contact: JointContact, body: RigidBody, origin: FloatArray, distance_m: float
) -> JudgedJoint:
    """Whether a collider of the link is where a hand takes hold; `distance_m` is how far the nearest one lies."""
    placed = [moved_shape(shape, pose(None, origin)) for shape in body.shapes]
    bound = max(POLICY.contact_m, POLICY.contact_share * diagonal(placed)) if placed else 0.0
    headline = f"is to be moved by its {contact.kind}, which has no collider"
    judged = _within(joint, "contact_to_collider", distance_m, bound, "m", "asset/joint-contact-astray", headline)
    return replace(judged, review=bool(judged.diagnostics))


def _within(
    joint: MechanismJoint, figure: str, value: float, bound: float, unit: str, code: str, headline: str
) -> JudgedJoint:
    """A check that `value` is at most `bound`, with a finding on the joint where it is not."""
    name, passed = f"joint.{joint.name}.{figure}", value <= bound
    check = Check(name=name, value=min(value, NOT_FINITE), bound=bound, unit=unit, passed=passed)
    if passed:
        return JudgedJoint((check,), ())
    where = joint.where or Location(prim=joint.name)
    text = f"joint '{joint.source_name or joint.name}' {headline}"
    return JudgedJoint((check,), (finding(code, text, where=where, value=check.value, bound=bound, unit=unit),))


def _unstable(subject: JointSubject, ratio: float) -> JudgedJoint:
    check = subject.check("speed", ratio, 1.0, "of the highest possible")
    headline = "explodes" if ratio == NOT_FINITE else f"moves {ratio:.3g} times as fast as anything can move it"
    return JudgedJoint((check,), (subject.finding("asset/joint-unstable", headline, check),))


def _speeds(subject: JointSubject) -> JudgedJoint:
    ratio = max(run.speed_mps / run.bound_mps if run.bound_mps > 0.0 else NOT_FINITE for run in subject.exercise.runs)
    if ratio > 1.0:
        return _unstable(subject, ratio)
    return JudgedJoint((subject.check("speed", ratio, 1.0, "of the highest possible"),), ())


def _reach(subject: JointSubject) -> JudgedJoint:
    """Both ends, driven and pushed: the worst run counts. Where links that others can move are in the way, so be it."""
    low, high = subject.exercise.reach
    bound = subject.tolerance(POLICY.reach_share)
    checks, findings, review = list[Check](), list[Diagnostic](), False
    verbs: tuple[tuple[Actuation, str], ...] = (("drive", "driven"), ("push", "pushed"))
    for actuation, verb in verbs:
        runs = subject.runs(actuation)
        if not runs:
            continue
        for end, missing, furthest in (
            ("lower", max(run.lowest for run in runs) - low, max(run.lowest for run in runs)),
            ("upper", high - min(run.highest for run in runs), min(run.highest for run in runs)),
        ):
            check = subject.check(f"{actuation}_reaches_{end}", max(missing, 0.0), bound, subject.unit)
            if check.passed:
                checks.append(check)
                continue
            blocker = _in_the_way(subject, furthest, low if end == "lower" else high)
            if blocker is None and subject.in_loop:
                continue  # The loop would take part; its closing joint is not in the exercise.
            checks.append(check)
            aim = low if end == "lower" else high
            if blocker is None:
                headline = f"{verb}, comes to {furthest:.4g} {subject.unit}, not to its {end} end at {aim:.4g}"
                findings.append(subject.finding("asset/joint-stuck", headline, check))
            else:
                headline = (
                    f"{verb}, comes to {furthest:.4g} of {aim:.4g} {subject.unit}: '{blocker.first}' and "
                    f"'{blocker.second}' collide"
                )
                findings.append(subject.finding("asset/joint-blocked", headline, check))
                # A joint without limits claims no range.
                limited = subject.joint.limits is not None
                review = review or (limited and check.value > POLICY.blocked_share * (high - low))
    return JudgedJoint(tuple(checks), tuple(findings[:1]), review)


def _range(subject: JointSubject) -> JudgedJoint:
    """How much of the declared range its limits leave out."""
    meant, own = subject.declared.limits, subject.joint.limits
    if meant is None or own is None:
        return JudgedJoint((), ())
    bound = subject.tolerance(POLICY.reach_share)
    missing = max(own[0] - meant[0], meant[1] - own[1], 0.0)
    check = subject.check("range_missing", missing, bound, subject.unit)
    if check.passed:
        return JudgedJoint((check,), ())
    headline = f"stops at {own[0]:.4g} .. {own[1]:.4g} {subject.unit}, not at {meant[0]:.4g} .. {meant[1]:.4g}"
    return JudgedJoint((check,), (subject.finding("asset/joint-stuck", headline, check),))


def judge_damping(joint: MechanismJoint, force_n: float) -> JudgedJoint:
    """Whether a hand can move the joint against its damping; `force_n` is what that takes, over the range in 10 s."""
    headline = f"takes {force_n:.3g} N to move slowly against its damping"
    return _within(joint, "damping_force", force_n, POLICY.damping_n, "N", "asset/joint-stuck", headline)


def _in_the_way(subject: JointSubject, furthest: float, end: float) -> LinkOverlap | None:
    """The deepest overlap of links that collide, and that another joint could part, on the way that is missing."""
    low, high = subject.exercise.reach
    slack = (high - low) / 8.0  # two positions at which overlaps are measured
    between = min(furthest, end) - slack, max(furthest, end) + slack
    return next(
        (
            overlap
            for overlap in subject.exercise.overlaps
            if overlap.collides and not overlap.fixed and between[0] <= (overlap.position or 0.0) <= between[1]
        ),
        None,
    )


def _overrun(subject: JointSubject) -> JudgedJoint:
    """How far beyond a declared limit it went, driven and pushed."""
    if subject.declared.limits is None:
        return JudgedJoint((), ())
    low, high = subject.declared.limits
    bound = subject.tolerance(POLICY.overrun_share)
    over = max(max(low - run.lowest, run.highest - high) - run.step for run in subject.exercise.runs)
    check = subject.check("overrun", max(over, 0.0), bound, subject.unit)
    if check.passed:
        return JudgedJoint((check,), ())
    headline = f"goes {check.value:.3g} {subject.unit} beyond a limit of {low:.4g} .. {high:.4g}"
    return JudgedJoint((check,), (subject.finding("asset/joint-overruns-limit", headline, check),))


def _axis(subject: JointSubject) -> JudgedJoint:
    """The measured axis beside the declared one, sign included; a joint that hardly moved shows none."""
    axis = subject.exercise.axis
    if axis is None:
        return JudgedJoint((), ())
    cosine = float(np.clip(axis @ subject.declared.axis, -1.0, 1.0))
    check = subject.check("axis", float(np.degrees(np.arccos(cosine))), POLICY.axis_deg, "deg")
    if check.passed:
        return JudgedJoint((check,), ())
    opposite = check.value > 180.0 - POLICY.axis_deg
    headline = "moves the other way round than declared" if opposite else "moves along another axis than declared"
    return JudgedJoint((check,), (subject.finding("asset/joint-axis-astray", headline, check),))


def _return(subject: JointSubject) -> JudgedJoint:
    missed = max((run.left_rest for run in subject.runs("drive")), default=0.0)
    check = subject.check("returns", missed, subject.tolerance(POLICY.return_share), subject.unit)
    if check.passed:
        return JudgedJoint((check,), ())
    headline = f"ends {missed:.3g} {subject.unit} from its rest position"
    return JudgedJoint((check,), (subject.finding("asset/joint-no-return", headline, check),))


def _penetration(subject: JointSubject) -> JudgedJoint:
    """Overlap, beyond rest, of links that this joint alone moves against each other and that are apart at rest.

    Links that overlap at rest are meant to (`links-filtered`), and those that collide stop each other (`_reach`).
    """
    if subject.in_loop:
        return JudgedJoint((), ())
    meant = {
        frozenset((o.first, o.second)) for o in subject.at_rest if not o.collides and o.depth_m > POLICY.penetration_m
    }
    counted = [
        o
        for o in subject.exercise.overlaps
        if o.fixed and not o.collides and frozenset((o.first, o.second)) not in meant
    ]
    worst = max(counted, key=lambda overlap: overlap.depth_m, default=None)
    check = subject.check("penetration", worst.depth_m if worst else 0.0, POLICY.penetration_m, "m")
    if check.passed or worst is None:
        return JudgedJoint((check,), ())
    headline = (
        f"drives '{worst.second}' {worst.depth_m:.3g} m into '{worst.first}' at {worst.position:.4g} {subject.unit}"
    )
    passing = subject.finding("asset/joint-penetration", headline, check)
    # A joint without limits makes its turn wherever that leads.
    return JudgedJoint((check,), (passing,), review=subject.joint.limits is not None)


def _probe(subject: JointSubject) -> JudgedJoint:
    probe = subject.exercise.probe
    if probe is None:
        return JudgedJoint((), ())
    slipped = float(np.linalg.norm(probe.end - probe.start))
    check = subject.check("probe_lags", slipped, POLICY.probe_share * probe.moved_m, "m")
    if check.passed:
        return JudgedJoint((check,), ())
    headline = f"moves its link by {probe.moved_m:.3g} m, and what lies inside lags {slipped:.3g} m behind"
    return JudgedJoint((check,), (subject.finding("asset/joint-probe-lost", headline, check),), review=True)
