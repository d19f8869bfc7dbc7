"""Joint states of articulated assets: positions as written become positions in m and rad, or findings.

A key of `joints` is the name of a joint, also that of the source; with `_deg` after it the position is in degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TypeAlias

import numpy as np

from geom.mechanism_pose import joint_positions, link_motions, movable_joints
from geom.pose import apply
from scenec.source.check_units import MOST_ANGLE_RAD
from schemas.diagnostics import Diagnostic, finding
from schemas.mechanism import Mechanism, MechanismJoint
from source.hint import did_you_mean

JointState: TypeAlias = tuple[tuple[str, float], ...]
"""(joint, position in m or rad) of the joints whose positions are written, by name; empty: all at rest."""

DEGREES = "_deg"
# m or rad, and share of a limit, by which a position may pass it: limits went through the degrees of USD in float32,
# whose rounding is 6e-8 of the number.
LIMIT_SLACK = 1e-6
LOOP_SLACK_M = 1e-3  # by which the ends of a closing joint may come apart
MOST_JOINTS = 12  # that a finding lists


def joint_state(
    asset_id: str, mechanism: Mechanism | None, written: Mapping[str, float]
) -> tuple[JointState, tuple[tuple[str, Diagnostic], ...]]:
    """The state that `written` describes, and findings, each with the key that it is about; a state with findings is
    none."""
    state: dict[str, float] = {}
    key_of: dict[str, str] = {}
    findings: list[tuple[str, Diagnostic]] = []
    for key, value in written.items():
        joint, in_degrees = _joint_of(mechanism, key)
        wrong = None if joint is None else _wrong_kind(joint, key, in_degrees)
        if mechanism is None or joint is None:
            findings.append((key, unknown_joint(asset_id, mechanism, key)))
        elif wrong is not None:
            findings.append((key, wrong))
        elif joint.name in state:
            headline = f"the position of `{joint.name}` is written twice: `{key_of[joint.name]}` and `{key}`"
            findings.append((key, finding("scene/given-twice", headline)))
        else:
            position = math.radians(value) if in_degrees else value
            state[joint.name], key_of[joint.name] = _on_limit(joint, position), key
            findings += [(key, outside) for outside in _outside(joint, value, position, in_degrees)]
    if mechanism is not None and state and not findings:
        findings += [(key_of[min(key_of)], wrong) for wrong in _dependent(mechanism, state)]
    return tuple(sorted(state.items())), tuple(findings)


def unknown_joint(asset_id: str, mechanism: Mechanism | None, name: str) -> Diagnostic:
    """The finding that an asset has no joint of that name that moves on its own."""
    names = [joint.name for joint in movable_joints(mechanism)] if mechanism is not None else []
    if not names:
        return finding("scene/unknown-joint", f"`{asset_id}` has no joints that could be set", value=name)
    listed = ", ".join(names[:MOST_JOINTS]) + (f" and {len(names) - MOST_JOINTS} more" if names[MOST_JOINTS:] else "")
    headline = f"`{asset_id}` has no joint `{name}`{did_you_mean(name, names)}; it has {listed}"
    return finding("scene/unknown-joint", headline, value=name, bound=listed)


def joint_named(mechanism: Mechanism, name: str) -> MechanismJoint | None:
    """The joint of that name; where there is none, the joint of that name in the source."""
    joints_here = (joint for joint in mechanism.joints if joint.name == name)
    return next(joints_here, None) or next((joint for joint in mechanism.joints if joint.source_name == name), None)


def all_positions(mechanism: Mechanism, state: JointState) -> tuple[tuple[str, float], ...]:
    """(joint, position) of every joint that has one number, those that follow others included, by name."""
    positions = joint_positions(mechanism, dict(state))
    return tuple(sorted((joint.name, positions[joint.name]) for joint in mechanism.tree if joint.kind != "ball"))


def differs_from_rest(mechanism: Mechanism, state: JointState) -> bool:
    """Whether a state takes any joint elsewhere than it is at rest, be it by a coupling whose offset does so."""
    positions = dict(all_positions(mechanism, state))
    return any(abs(positions[one.name] - one.rest) > LIMIT_SLACK for one in mechanism.tree if one.name in positions)


def _joint_of(mechanism: Mechanism | None, key: str) -> tuple[MechanismJoint | None, bool]:
    """The joint that a key names, and whether its position is in degrees."""
    if mechanism is None:
        return None, False
    joint = joint_named(mechanism, key)
    if joint is None and key.endswith(DEGREES):
        return joint_named(mechanism, key.removesuffix(DEGREES)), True
    return joint, False


def _wrong_kind(joint: MechanismJoint, key: str, in_degrees: bool) -> Diagnostic | None:
    if joint.coupling is not None:
        coupling = joint.coupling
        headline = f"`{joint.name}` follows `{coupling.joint}` ({coupling.multiplier:g} times its position"
        headline += f" + {coupling.offset:g})" if coupling.offset else ")"
        return finding("scene/joint-follows", headline, value=key, bound=coupling.joint)
    if joint.closes_loop:
        headline = f"`{joint.name}` closes a loop: its position follows from the other joints"
        return finding("scene/joint-follows", headline, value=key)
    if joint.kind == "ball":
        headline = f"`{joint.name}` turns about a point, so that no single number is its position"
        return finding("scene/unknown-joint", headline, value=key)
    if in_degrees and not joint.is_angular:
        headline = f"`{joint.name}` slides: its position is in metres, as `{joint.name}`"
        return finding("scene/invalid-value", headline, value=key)
    return None


def _on_limit(joint: MechanismJoint, position: float) -> float:
    """The position, on a limit that it passes by rounding only."""
    if joint.limits is None:
        return position
    low, high = joint.limits
    return min(max(position, low), high) if _within(joint, position) else position


def _within(joint: MechanismJoint, position: float) -> bool:
    """Whether a position passes no limit, but for rounding."""
    low, high = joint.limits or (-math.inf, math.inf)
    slack = LIMIT_SLACK * max(1.0, abs(position))
    return low - slack <= position <= high + slack


def _outside(joint: MechanismJoint, value: float, position: float, in_degrees: bool) -> Iterator[Diagnostic]:
    """A finding where a position is outside the limits, or in another unit than it says."""
    outside = not _within(joint, position)
    if joint.is_angular and not in_degrees:
        as_degrees = _within(joint, math.radians(value))
        if abs(value) > MOST_ANGLE_RAD and (outside or joint.limits is None) and as_degrees:
            headline = (
                f"`{joint.name}` at {value:g} rad is {_beyond(joint)}; did you mean `{joint.name}_deg: {value:g}`?"
            )
            bound = 2.0 * math.pi if joint.limits is None else _bounds(joint)
            yield finding("scene/degrees-suspected", headline, value=value, bound=bound, unit="rad")
            return
    if outside:
        headline = f"`{joint.name}` at {_shown(joint, position)} is {_beyond(joint)}"
        unit = "rad" if joint.is_angular else "m"
        yield finding("scene/joint-range", headline, value=position, bound=_bounds(joint), unit=unit)


def _beyond(joint: MechanismJoint) -> str:
    if joint.limits is None:
        return "more than a full turn"
    return f"outside its limits, {_shown(joint, joint.limits[0])} and {_shown(joint, joint.limits[1])}"


def _bounds(joint: MechanismJoint) -> str:
    low, high = joint.limits or (-math.inf, math.inf)
    return f"{low:.6g} to {high:.6g}"


def _shown(joint: MechanismJoint, position: float) -> str:
    """A position with its unit: `0.2 m`, `1.571 rad (90 deg)`."""
    if not joint.is_angular:
        return f"{position:.4g} m"
    return f"{position:.4g} rad ({math.degrees(position):.4g} deg)"


def _dependent(mechanism: Mechanism, state: Mapping[str, float]) -> Iterator[Diagnostic]:
    """Findings on joints whose positions follow from those written: followers past a limit, loops that open."""
    positions, rest = joint_positions(mechanism, state), joint_positions(mechanism, {})
    for joint in mechanism.tree:
        if joint.coupling is None or positions[joint.name] == rest[joint.name]:
            continue
        if not _within(joint, positions[joint.name]):
            headline = (
                f"`{joint.name}`, which follows, comes to {_shown(joint, positions[joint.name])}, {_beyond(joint)}"
            )
            unit = "rad" if joint.is_angular else "m"
            yield finding("scene/joint-range", headline, value=positions[joint.name], bound=_bounds(joint), unit=unit)
    motions = link_motions(mechanism, state)
    for joint in mechanism.joints:
        if joint.closes_loop:
            ends = [apply(motions[link], joint.anchor[None])[0] for link in (joint.parent, joint.child)]
            apart_m = float(np.linalg.norm(ends[1] - ends[0]))
            if apart_m > LOOP_SLACK_M and joint.kind != "prismatic":
                headline = f"the loop that `{joint.name}` closes comes apart by {1e3 * apart_m:.3g} mm in this state"
                yield finding("scene/joint-loop", headline, value=apart_m, bound=LOOP_SLACK_M, unit="m")
