"""Checks of quaternion order and velocity frame: the reading that agrees with the motion is taken."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.diagnostics import Location, finding
from simgap.recording.checks.check import Checked, Setting, mapped
from simgap.recording.checks.quaternions import one_sign
from simgap.recording.checks.rates import fast_rows, linear_slopes, mismatch, turning_slopes
from simgap.recording.checks.stack import stacked
from simgap.recording.recording import Trial

RIGHT_MISMATCH = 0.35  # Mismatch of a right reading: noise and half a frame of age stay below.
DECISIVE = 2.0  # times better than what the file declares


@dataclass(frozen=True)
class Reading:
    """One way to read the file: what differs from the declaration, and the trials read so."""

    what: str
    change: Callable[[Trial], Trial]
    code: str = ""
    text: str = ""


def check_orientation(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Angular velocity against orientation, for both quaternion orders and both frames; the declared reading is kept
    unless another one agrees and is DECISIVE times better.
    """
    declared = set(setting.spec.columns)
    if not {"w_body", "w_world"} & declared or not {"q_wxyz", "q_xyzw"} & declared:
        return Checked(trials)
    written, other = ("w_body", "w_world") if "w_body" in declared else ("w_world", "w_body")

    def read_as(column: str, quats: Callable[[Trial], FloatArray]) -> Callable[[Trial], Trial]:
        return lambda t: replace(t, quat_wxyz=quats(t), w_B=_body_rate(t, written, column, quats(t)))

    order = "quaternions are in the other order (wxyz, xyzw) than declared"
    readings = (
        Reading("as declared", lambda t: t),
        Reading("frame", read_as(other, _quats), "gap/velocity-frame", f"'{written}' is in the other frame; turned"),
        Reading("order", read_as(written, _rolled), "gap/quaternion-order", f"{order}; read so"),
        Reading(
            "both", read_as(other, _rolled), "gap/quaternion-order", f"{order}, and '{written}' in the other frame"
        ),
    )

    def off(read: tuple[Trial, ...]) -> float:
        slopes, recorded = turning_slopes(read, _quats).central, stacked(read, lambda t: t.w_B)
        return mismatch(recorded, slopes, fast_rows(slopes, recorded))

    return _decide(trials, readings, off, "angular velocity")


def check_linear_frame(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Velocity in world axes, as declared, or in the body's."""
    declared = set(setting.spec.columns)
    if not {"v", "p"} <= declared or not {"q_wxyz", "q_xyzw"} & declared:
        return Checked(trials)
    slopes = linear_slopes(trials, lambda t: t.p).central

    def turned(t: Trial) -> Trial:
        return replace(t, v_W=np.einsum("nij,nj->ni", matrix_of(t.quat_wxyz), t.v_W))

    def off(read: tuple[Trial, ...]) -> float:
        recorded = stacked(read, lambda t: t.v_W)
        return mismatch(recorded, slopes, fast_rows(slopes, recorded))

    text = "'v' is in body axes; turned to world axes"
    readings = (Reading("as declared", lambda t: t), Reading("frame", turned, "gap/velocity-frame", text))
    return _decide(trials, readings, off, "velocity")


def _decide(
    trials: tuple[Trial, ...],
    readings: Sequence[Reading],
    off: Callable[[tuple[Trial, ...]], float],
    what: str,
) -> Checked:
    """The first reading if it agrees with the motion, else the best one if that agrees and is clearly better."""
    declared_mismatch = off(trials)
    if declared_mismatch <= RIGHT_MISMATCH:
        return Checked(trials)
    alternatives = [(off(mapped(trials, reading.change)), k) for k, reading in enumerate(readings[1:], 1)]
    best_mismatch, k = min(alternatives)
    where = Location(file="measurement.yaml")
    if best_mismatch <= RIGHT_MISMATCH and declared_mismatch >= DECISIVE * best_mismatch:
        text = f"{readings[k].text} (mismatch {declared_mismatch:.2f}, then {best_mismatch:.2f})"
        diagnostic = finding(readings[k].code, text, where=where, value=declared_mismatch, bound=RIGHT_MISMATCH)
        return Checked(mapped(trials, readings[k].change), (diagnostic,))
    text = f"recorded {what} does not follow from the motion in any frame or order (mismatch {declared_mismatch:.2f})"
    return Checked(
        trials,
        (finding("gap/velocity-inconsistent", text, where=where, value=declared_mismatch, bound=RIGHT_MISMATCH),),
    )


def _quats(trial: Trial) -> FloatArray:
    return trial.quat_wxyz


def _rolled(trial: Trial) -> FloatArray:
    """The four numbers of the file read in the other order than declared; which of the two was declared is known."""
    return one_sign(np.roll(trial.quat_wxyz, 1, axis=1))


def _body_rate(trial: Trial, written: str, column: str, quat_wxyz: FloatArray) -> FloatArray:
    """(n, 3) body-frame rate if the file's numbers are `column` and the orientation is `quat_wxyz`."""
    numbers = trial.w_B
    if written == "w_world":  # Undo what the reader did with the declared orientation.
        numbers = np.einsum("nij,nj->ni", matrix_of(trial.quat_wxyz), trial.w_B)
    return np.einsum("nji,nj->ni", matrix_of(quat_wxyz), numbers) if column == "w_world" else numbers
