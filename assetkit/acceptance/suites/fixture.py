"""Suite of objects with joints: a gripper opens doors and drawers by their handles, turns knobs and presses buttons.

Each joint is handled at the contact on record. What is opened or turned is taken between the pads, which then move
along the path of the joint and back, the hand turning along; where no pads can take it, closed fingers push it or hook
behind it. What is pressed is pushed by closed fingers. A joint passes if it passes in one of a few ways.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from assetkit.affordances.joint_holds import HandledJoint, Hold, friction_of, pad_force, pad_holds, push_holds
from geom.grasp.gripper import LARGE, MEDIUM, SMALL, Gripper
from schemas.articulation import JointContact, JointUse
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.mechanism import MechanismJoint
from sim.joint_exercise import Articulation
from sim.joint_handling import HandlingOutcome, HandlingTask
from sim.port import Simulator

JOINT_TRACE_S = 1.0 / 20.0
HAND_OF_PADS = 2.0  # force of the hand over that of a pad: what both pads could carry at a friction of 1
_Propose = Callable[[HandledJoint, Gripper], tuple[list[Hold], str]]


@dataclass(frozen=True)
class _Contacted:
    """A joint with its use and the contact on record."""

    joint: MechanismJoint
    use: JointUse
    contact: JointContact

    @property
    def end(self) -> float:
        """The position to which it is moved: open, or as far as a hand turns in one go."""
        closed, way = self.use.closed.value, self.use.open.value - self.use.closed.value
        return closed + (max(min(way, POLICY.joint_turn_rad), -POLICY.joint_turn_rad) if self.joint.is_angular else way)


class FixtureSuite:
    """See the module."""

    name = "fixture"
    varies = False
    roles: frozenset[Role] = frozenset({"fixture", "mechanism", "openable", "turnable", "pressable"})
    codes = (
        "asset/handle-not-taken",
        "asset/handle-astray",
        "asset/handle-not-opened",
        "asset/handle-lost",
        "asset/handle-forced",
        "asset/handle-not-returned",
        "asset/handle-unstable",
    )

    def obstacle(self, subject: Subject) -> str:
        """A rigid object has nothing to move; without a use on record nothing says where a hand belongs."""
        if not subject.is_articulated:
            return "it has no joints"
        return "" if _contacted(subject) else "no joint of a known use has a contact on record"

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """All joints of a known use, one after the other, each in the way that went best."""
        content = subject.content
        assert content.mechanism is not None, "`obstacle` is empty"
        articulation = Articulation(content.mechanism, content.links, content.filtered_pairs)
        where = Location(file=subject.main_file.name)
        runs = [_handle(one, articulation, where, simulator, conditions) for one in _contacted(subject)]
        return SuiteRun(
            tuple(check for run in runs for check in run.checks),
            tuple(finding for run in runs for finding in run.findings),
            handled=tuple(trace for run in runs for trace in run.handled),
        )


def _contacted(subject: Subject) -> list[_Contacted]:
    """The joints that are handled: those of a known use, with a contact on a link of the object."""
    mechanism = subject.content.mechanism
    if mechanism is None:
        return []
    joints = {j.name: j for j in mechanism.tree if j.kind != "ball" and j.coupling is None}
    links = {link.name for link in mechanism.links}
    known = [
        _Contacted(joints[use.joint], use, use.contact.value)
        for use in subject.joint_uses
        if use.joint in joints
        and use.group.confidence > 0.0
        and use.contact is not None
        and use.contact.value.link in links
        and use.open.value != use.closed.value
    ]
    return known[: POLICY.joints]


def _handle(
    one: _Contacted, articulation: Articulation, where: Location, simulator: Simulator, conditions: Conditions
) -> SuiteRun:
    handled = HandledJoint(articulation, one.joint, one.contact, one.use.closed.value, one.end)
    astray = _pull_astray(one, handled, where)
    if not astray.passes:
        return astray
    ways: Sequence[_Propose] = (push_holds,) if one.use.task == "press" else (pad_holds, push_holds)
    runs: list[SuiteRun] = []
    reasons: list[str] = []
    for propose in ways:
        holds, reason = _holds(handled, propose)
        reasons += [] if holds else [reason]
        for hold in holds[: POLICY.joint_tries]:
            runs.append(_try(one, handled, hold, where, simulator, conditions))
            if runs[-1].passes:
                break
        if runs and runs[-1].passes:
            break
    if not runs:
        checks = CheckList(where)
        headline = f"'{one.joint.name}': no gripper gets hold of '{one.contact.link}': {'; '.join(reasons)}"
        checks.add("asset/handle-not-taken", headline, at_least(_name(one, "ways"), 0, 1, ""))
        return replace(checks.run(), checks=(*astray.checks, *checks.checks))
    best = max(runs, key=lambda run: sum(check.passed for check in run.checks))
    return replace(best, checks=(*astray.checks, *best.checks))


def _pull_astray(one: _Contacted, handled: HandledJoint, where: Location) -> SuiteRun:
    """The direction on record against that in which the joint moves the contact first."""
    checks = CheckList(where)
    moving = replace(handled, start=one.joint.rest, end=one.joint.rest + handled.end - handled.start).direction(
        np.array([one.contact.position_m])
    )[0]
    cos = float(np.clip(moving @ np.array(one.contact.pull), -1.0, 1.0))
    angle = math.degrees(math.acos(cos)) if moving.any() else 0.0
    headline = f"'{one.joint.name}' moves its {one.contact.kind} {angle:.0f} degrees off the direction on record"
    most = math.degrees(POLICY.joint_pull_rad)
    checks.add("asset/handle-astray", headline, at_most(_name(one, "pull"), angle, most, "deg"))
    return checks.run()


def _holds(handled: HandledJoint, propose: _Propose) -> tuple[list[Hold], str]:
    """The ways of the first gripper that has some with a path that is free for long enough; or none, and why."""
    reasons: list[str] = []
    for gripper in (MEDIUM, SMALL, LARGE):
        holds, reason = propose(handled, gripper)
        usable = [hold for hold in holds if hold.free >= POLICY.joint_free]
        if usable:
            return usable, ""
        longest = max((hold.free for hold in holds), default=0.0)
        if longest > 0.0:
            reason = f"the hand would run into the object after {100.0 * longest:.0f} % of the path"
        reasons.append(reason)
    doing = "pads" if propose is pad_holds else "fingers"
    return [], f"{doing}: {reasons[0]}"


def _try(
    one: _Contacted,
    handled: HandledJoint,
    hold: Hold,
    where: Location,
    simulator: Simulator,
    conditions: Conditions,
) -> SuiteRun:
    """One way: there and back. What has no spring and was pushed is pushed back from its other side."""
    sprung = one.joint.stiffness > 0.0
    task = _task(handled, hold, conditions, comes_back=hold.takes or sprung)
    outcome = simulator.handle_joint(handled.articulation, task)
    traces = [trace for trace in (outcome.trace,) if trace is not None]
    checks = CheckList(where)
    way = handled.end - handled.start
    label = f"'{one.joint.name}' by {'the pads' if hold.takes else 'closed fingers'} of the {hold.gripper.name} gripper"
    checks.checks.append(at_least(_name(one, "by_pads"), float(hold.takes), 0.0, ""))
    _moved(checks, one, label, hold, outcome, way)
    if checks.findings:
        return checks.run(handled=traces)
    back, returning = outcome.back, "the hand moves it back" if hold.takes else "its spring brings it back"
    if not hold.takes and not sprung:
        pushed = _push_back(one, handled, outcome.reached, simulator, conditions)
        if pushed is None:
            return checks.run(handled=traces)
        back, returning = pushed.back, "closed fingers push it back"
        traces += [pushed.trace] if pushed.trace is not None else []
    left = abs(back - outcome.began) / abs(way)
    headline = f"{label}: {100.0 * left:.0f} % of its way is left when {returning}"
    checks.add("asset/handle-not-returned", headline, at_most(_name(one, "back"), left, POLICY.joint_back, "of way"))
    return checks.run(handled=traces)


def _moved(checks: CheckList, one: _Contacted, label: str, hold: Hold, outcome: HandlingOutcome, way: float) -> None:
    """That the joint is moved calmly, followed by grip and with a force that the gripper has."""
    speed = outcome.fastest if outcome.finite else math.inf
    jumps = f"{label}: it moves {speed:.3g} times as fast as the hand"
    checks.add("asset/handle-unstable", jumps, at_most(_name(one, "speed"), speed, POLICY.joint_speed, "of hand"))
    if not outcome.finite:
        return
    share = (outcome.reached - one.use.closed.value) / way
    stays = f"{label}: it makes {100.0 * share:.0f} % of its way while the hand makes {100.0 * hold.free:.0f} %"
    least = POLICY.joint_followed * hold.free
    opened = at_least(_name(one, "opened"), share, least, "of way")
    checks.add("asset/handle-not-opened", stays, opened)
    if not opened.passed:
        return
    if hold.takes:
        slips = f"{label}: both pads touch it for {100.0 * outcome.kept:.0f} % of the time"
        checks.add("asset/handle-lost", slips, at_least(_name(one, "kept"), outcome.kept, POLICY.joint_kept, "of time"))
    needs = f"{label}: it takes {outcome.force_n:.3g} N"
    force = at_most(_name(one, "force"), outcome.force_n, hold.gripper.force_n, "N")
    checks.add("asset/handle-forced", needs, force)


def _push_back(
    one: _Contacted, handled: HandledJoint, reached: float, simulator: Simulator, conditions: Conditions
) -> HandlingOutcome | None:
    """Closed fingers that push the joint from where it is to where it was; None where they cannot get there."""
    open_now = HandledJoint(handled.articulation, one.joint, one.contact, reached, handled.start)
    holds, _ = _holds(open_now, push_holds)
    if not holds:
        return None
    return simulator.handle_joint(handled.articulation, _task(open_now, holds[0], conditions, comes_back=False))


def _task(handled: HandledJoint, hold: Hold, conditions: Conditions, *, comes_back: bool) -> HandlingTask:
    """The motion over what of the path is free; fingers that begin before the link go as much further."""
    joint, way = handled.joint, hold.free * (handled.end - handled.start)
    task = HandlingTask(
        joint.name,
        handled.start,
        handled.start + way,
        hold.X_AG,
        hold.opening_m,
        hold.takes,
        comes_back,
        force_n=pad_force(handled, hold),
        hand_n=HAND_OF_PADS * hold.gripper.force_n,
        friction=friction_of(handled) if conditions.friction is None else conditions.friction,
        gripper=hold.gripper,
        step_s=conditions.step_s,
        trace_s=JOINT_TRACE_S,
    )
    arm_m = float(np.linalg.norm(np.cross(handled.place() - joint.anchor, joint.axis))) if joint.is_angular else 1.0
    return replace(task, end=task.end + math.copysign(hold.gap_m / max(arm_m, hold.gap_m), way))


def _name(one: _Contacted, figure: str) -> str:
    return f"joint.{one.joint.name}.{figure}"
