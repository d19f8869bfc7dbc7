"""The sim gap of the demo: doors that slow down although their model has no friction, generated on the spot."""

from __future__ import annotations

import io
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from cli.engines import REPLAY_ENGINE
from jobs.cache import write_atomically
from schemas.arrays import FloatArray
from schemas.sim_gap.report import GapReport
from simgap.recording.read import read
from simgap.run import Tick, search

# The truth, which the search does not see: Dahl's friction (P. R. Dahl, Aerospace Corp. TOR-0158, 1968), integrated by
# SciPy. The library has no such law; in steady sliding it equals Coulomb's.
FRICTION_NM, BRISTLES_NM_PER_RAD, INERTIA_KGM2 = 0.008, 20.0, 0.01
NOISE_RAD = 5e-4  # an encoder of 12 bits
PUSHES_RADPS = (0.8, 3.0)
PUSHES, SPAN_S, PERIOD_S = 10, 3.0, 0.01
_SPEC = f"""\
schema_version: 1
name: door
kind: mechanism
description: generated for the demo; the model below leaves out the friction that the recordings have
columns: {{t: t, q_door: angle}}
subject:
  joints:
    - {{name: door, inertia_kgm2: {INERTIA_KGM2}}}
"""


@dataclass(frozen=True)
class GapDemo:
    """The report on what was hidden; its files lie in `folder`, beside the page."""

    report: GapReport
    folder: str
    hidden_Nm: float = FRICTION_NM


def gap_demo(out: Path, *, jobs: int, tick: Tick) -> GapDemo:
    """Write recordings to `out/gap/recordings`, and what `mana gap find` says of them to `out/gap`."""
    since, folder = time.monotonic(), out / "gap"
    write_recordings(folder / "recordings")
    outcome = read(folder / "recordings")
    if outcome.value is None:  # Not bad input: the recordings are ours.
        raise RuntimeError(outcome.diagnostics[0].headline)
    report = search(outcome.value, outcome.diagnostics, folder, engine=REPLAY_ENGINE, jobs=jobs, tick=tick, since=since)
    return GapDemo(report, folder.name)


def write_recordings(folder: Path) -> None:
    """A measurement folder of a door on a vertical axis, pushed by hand and let go."""
    rng = np.random.default_rng(0)
    t_s = np.arange(0.0, SPAN_S, PERIOD_S)
    write_atomically(folder / "measurement.yaml", _SPEC.encode())
    for k in range(PUSHES):
        angle = coasting(rng.uniform(*PUSHES_RADPS) * (-1) ** k, t_s) + NOISE_RAD * rng.normal(size=len(t_s))
        table = io.StringIO()
        np.savetxt(table, np.stack([t_s, angle], axis=1), fmt="%.6f", delimiter=",", header="t,angle", comments="")
        write_atomically(folder / "trajectories" / f"push_{k}.csv", table.getvalue().encode())


def coasting(rate_radps: float, t_s: FloatArray) -> FloatArray:
    """True angle of the door (n,): friction is the force of bristles that bend and slip."""

    def change(_: float, state: FloatArray) -> list[float]:
        _, qd, bent = state
        return [
            qd,
            -BRISTLES_NM_PER_RAD * bent / INERTIA_KGM2,
            qd - abs(qd) * BRISTLES_NM_PER_RAD / FRICTION_NM * bent,
        ]

    start = [0.0, rate_radps, 0.0]
    return solve_ivp(change, (0.0, t_s[-1]), start, t_eval=t_s, method="LSODA", rtol=1e-8, atol=1e-10).y[0]
