"""The declared mechanism over whole trials: roll-outs here and in an engine at the user's step, beside the readings.

All start from the same smoothed first row and get the same inputs. What the two roll-outs differ by is the part of the
gap that the engine and its step make; what ours differs from the readings by is the whole gap.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jobs.cell import CellResult, Limits
from jobs.warm import run_module
from schemas.arrays import FloatArray
from schemas.sim_gap.report import EngineComparison, EngineDifference, RolloutEngine
from sim.dynamics.mechanism import MechanismModel, rollout
from simgap.case import Case, declared_rollout, replay_engine
from simgap.engine_comparison.worker import EngineRequest, result_file
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.recording.recording import Trial
from simgap.report.side_by_side import joint_windows, read_positions

FINER = 4  # steps of the second pass, per step of the user's: the part that the step makes falls by it
_MOST_REPLAYED, _MOST_SIMULATED_S = 12, 30.0  # of held-out trials that are replayed
LIMITS = Limits(seconds=60.0, memory_mb=4096)
_METHOD = "damping and drives as efforts set before each step, dry friction as a motor of limited effort"


@dataclass(frozen=True)
class TrialRollouts:
    """One trial: stamps t_s (k,), and joint positions (k, j) as read, rolled out here, in the engine, in finer steps.

    `finer` is None where that pass did not get so far.
    """

    trial: str
    t_s: FloatArray
    measured: FloatArray
    ours: FloatArray
    engine: FloatArray
    finer: FloatArray | None


@dataclass(frozen=True)
class EngineRollouts:
    """Trials that the engine rolled out, the engine, and why some or all are missing; empty where none is."""

    engine: RolloutEngine
    trials: tuple[TrialRollouts, ...]
    failure: str


def rollouts_in_engine(case: Case, mechanism: MechanismModel, limits: Limits = LIMITS) -> EngineRollouts:
    """Held-out trials in the engine of `case` at the step of the measurement; never raises for what the engine does."""
    step_s = case.measurement.spec.simulator.step_s
    engine = RolloutEngine(name=replay_engine(case.engine).name, method=_METHOD, step_s=step_s)
    applied = apply_terms(mechanism, ())
    trials = _chosen([t for t in case.measurement.trials if t.id in case.trials.test])
    windows = tuple(joint_windows(trial, applied) for trial in trials)
    with tempfile.TemporaryDirectory() as folder:
        request, out = Path(folder, "request.bin"), Path(folder, "out")
        out.mkdir()
        steps_s = (step_s, step_s / FINER)
        request.write_bytes(pickle.dumps(EngineRequest(case.engine, mechanism, windows, steps_s)))
        arguments = [str(request), str(out)]
        ended = run_module("simgap.engine_comparison.worker", arguments, limits, env={"OMP_NUM_THREADS": "1"})
        passes = [[_loaded(result_file(out, n, k)) for k in range(len(trials))] for n in range(len(steps_s))]
    own_step_s = declared_rollout(case).step_s
    assert own_step_s is not None  # Mechanisms are rolled out in steps.
    rows = []
    for trial, window, at_step, finer in zip(trials, windows, *passes, strict=True):
        if at_step is not None:
            ours, _ = rollout(mechanism, window, largest_step_s=own_step_s)
            rows.append(TrialRollouts(trial.id, window.t_s[0], read_positions(trial), ours[0], at_step, finer))
    return EngineRollouts(engine, tuple(rows), _failure(ended, len(rows), len(trials), limits))


def compare_engines(rollouts: EngineRollouts, channels: Sequence[str], units: Sequence[str]) -> EngineComparison:
    """Rms differences over all rows of all trials, joint by joint; infinite where a roll-out is no number."""
    trials = rollouts.trials
    fine = [t for t in trials if t.finer is not None]

    def difference(j: int) -> EngineDifference:
        return EngineDifference(
            channel=channels[j],
            unit=units[j],
            between_engines=_rms([t.engine[:, j] - t.ours[:, j] for t in trials]),
            between_at_finer_step=_rms([t.finer[:, j] - t.ours[:, j] for t in fine if t.finer is not None])
            if len(fine) == len(trials)
            else None,
            ours_to_recording=_rms([t.ours[:, j] - t.measured[:, j] for t in trials]),
            engine_to_recording=_rms([t.engine[:, j] - t.measured[:, j] for t in trials]),
        )

    return EngineComparison(
        engine=rollouts.engine,
        trials=tuple(t.trial for t in trials),
        differences=tuple(difference(j) for j in range(len(channels))) if trials else (),
        failure=rollouts.failure,
    )


def most_telling(rollouts: EngineRollouts) -> tuple[int, int]:
    """Trial and joint where the engines differ most, over what the recording differs by."""
    parts = [
        [
            _rms([t.engine[:, j] - t.ours[:, j]]) / max(_rms([t.ours[:, j] - t.measured[:, j]]), 1e-12)
            for j in range(t.ours.shape[1])
        ]
        for t in rollouts.trials
    ]
    trial, joint = np.unravel_index(int(np.argmax(parts)), np.shape(parts))
    return int(trial), int(joint)


def _chosen(trials: Sequence[Trial]) -> list[Trial]:
    """The first ones, as many as the bounds allow, and one at least."""
    spans = np.cumsum([t.t_s[-1] - t.t_s[0] for t in trials])
    return list(trials[: max(1, min(_MOST_REPLAYED, int((spans <= _MOST_SIMULATED_S).sum())))])


def _loaded(file: Path) -> FloatArray | None:
    return np.load(file) if file.is_file() else None


def _rms(errors: Sequence[FloatArray]) -> float:
    squares = np.concatenate([e**2 for e in errors])
    mean = float(np.sqrt(squares.mean()))
    return mean if np.isfinite(mean) else float("inf")


def _failure(ended: CellResult, done: int, asked: int, limits: Limits) -> str:
    """Why trials are missing, as words; nothing where none is."""
    if ended.status == "ok" or done == asked:
        return ""
    last = (ended.output.strip().splitlines() or [""])[-1][:200]
    reasons = {"timeout": f"stopped after {limits.seconds:g} s", "out_of_memory": f"over {limits.memory_mb} MiB"}
    return f"{done} of {asked} trials: {reasons.get(ended.status, last or ended.status)}"
