"""Rolls out mechanisms in an engine, in a process of its own: `python -m simgap.engine_comparison.worker REQUEST OUT`.

From a pickled `EngineRequest` to files `OUT/<pass>_<trial>.npy` with joint positions (k, j) at the stamps of each
trial; each is complete as soon as it has its name.
"""

from __future__ import annotations

import os
import pickle
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim.dynamics.mechanism import MechanismModel, Windows
from simgap.case import replay_engine
from simgap.engine_comparison.fixed_steps import at_stamps, on_fixed_steps


@dataclass(frozen=True)
class EngineRequest:
    """The engine by its name, the mechanism, one window (1, k) per trial, and the step of each pass over them."""

    engine: str
    mechanism: MechanismModel
    windows: tuple[Windows, ...]
    steps_s: tuple[float, ...]


def result_file(folder: Path, number: int, trial: int) -> Path:
    """Where the motion of a trial in a pass is written."""
    return folder / f"{number}_{trial}.npy"


def work(request: EngineRequest, folder: Path) -> None:
    """Roll out every trial, one pass after the other."""
    engine = replay_engine(request.engine)
    for number, step_s in enumerate(request.steps_s):
        rollout = engine.mechanism_rollout_at(step_s)
        for k, windows in enumerate(request.windows):
            steps = on_fixed_steps(windows, step_s)
            q, _ = rollout(request.mechanism, steps, ())
            unfinished = folder / "unfinished.npy"
            np.save(unfinished, at_stamps(steps, q, windows.t_s[0]))
            os.replace(unfinished, result_file(folder, number, k))


if __name__ == "__main__":
    work(pickle.loads(Path(sys.argv[1]).read_bytes()), Path(sys.argv[2]))
