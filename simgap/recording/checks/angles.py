"""Checks of joint angles: removes wraps, converts degrees to radians."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from simgap.recording.checks.check import Checked, Hit, Setting, over_trials
from simgap.recording.recording import Trial

_TURN_RAD = 2.0 * np.pi
_TURN_DEG = 360.0
_SLACK = 0.15  # of a turn: the joint's own motion between two rows
_TURNS_SUSPECT = 3.0  # Hinges do not go round that often; wheels do, so this is only said.


def degrees_to_radians(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Columns of a turning joint that jump by 360 are degrees and are converted, rates too; a huge range is reported.

    A rate column is taken to share the unit; `check_units` compares it with the angle afterwards.
    """
    degrees = np.zeros(len(setting.joints), dtype=bool)
    hits: list[Hit] = []
    suspects: list[Hit] = []
    for k in np.flatnonzero(setting.turns):
        jumps = np.array([_jumps_by_360(t.q[:, k]) for t in trials])
        name = setting.joints[k].name
        ranges = np.array([np.ptp(t.q[:, k]) for t in trials])
        if jumps.sum() > 0:
            degrees[k] = True
            hits += [Hit(t, n, f"{name} jumps by 360, {int(n)} times") for t, n in zip(trials, jumps, strict=True) if n]
        else:
            most = _plausible_range(setting, name)
            suspects += [Hit(t, r, f"{name} spans {r:.4g}") for t, r in zip(trials, ranges, strict=True) if r > most]
    if degrees.any():
        trials = tuple(_scaled(trial, degrees) for trial in trials)
    text = "angles are in degrees; converted with their rates"
    findings = over_trials("gap/degrees", text, hits, len(trials), unit="jumps")
    text = "angles span more than a hinge does; if they are degrees, convert them"
    return Checked(trials, findings + over_trials("gap/degrees-suspected", text, suspects, len(trials), unit="rad"))


def _plausible_range(setting: Setting, joint: str) -> float:
    """What a turning joint may span: three times its declared limits, else a few turns."""
    declared = next((j.limits for j in setting.spec.subject.joints if j.name == joint), None)
    return 3.0 * (declared[1] - declared[0]) if declared else _TURNS_SUSPECT * _TURN_RAD


def unwrap_angles(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Turning joints without jumps by a whole turn; commands follow, on the turn nearest to the angle."""
    turning = np.flatnonzero(setting.turns)
    hits: list[Hit] = []
    continuous: list[Trial] = []
    for trial in trials:
        count = sum(wraps(trial.q[:, k], _TURN_RAD) for k in turning)
        if count:
            q, command = trial.q.copy(), trial.command.copy()
            for k in turning:
                q[:, k] = unwrapped(q[:, k])
                command[:, k] = _beside(unwrapped(command[:, k]), q[:, k])
            trial = replace(trial, q=q, command=command)
            hits.append(Hit(trial, count, f"{count} jumps by a turn"))
        continuous.append(trial)
    return Checked(
        tuple(continuous),
        over_trials("gap/angle-wrapped", "wrapped angles made continuous", hits, len(trials), unit="jumps"),
    )


def _jumps_by_360(angle: FloatArray) -> int:
    """Whole turns in degrees; an angle that is wrapped stays within one."""
    return wraps(angle, _TURN_DEG) if np.ptp(angle) <= 1.01 * _TURN_DEG else 0


def wraps(angle: FloatArray, turn: float) -> int:
    """How many steps of `angle` (n,) are whole turns but for the joint's own motion."""
    return int(_whole_turns(np.diff(angle), turn).astype(bool).sum())


def unwrapped(angle_rad: FloatArray) -> FloatArray:
    """The same angle (n,) without jumps by whole turns; single wild values are left for the outlier check."""
    turns = np.cumsum(_whole_turns(np.diff(angle_rad), _TURN_RAD))
    return angle_rad - np.concatenate([[0.0], turns * _TURN_RAD])


def _beside(command_rad: FloatArray, angle_rad: FloatArray) -> FloatArray:
    return command_rad - np.rint((command_rad[0] - angle_rad[0]) / _TURN_RAD) * _TURN_RAD


def _whole_turns(steps: FloatArray, turn: float) -> FloatArray:
    whole = np.rint(steps / turn)
    return np.where(np.abs(steps - whole * turn) < _SLACK * turn, whole, 0.0)


def _scaled(trial: Trial, degrees: FloatArray) -> Trial:
    factor = np.where(degrees, np.pi / 180.0, 1.0)
    return replace(trial, q=trial.q * factor, qd=trial.qd * factor, command=trial.command * factor)
