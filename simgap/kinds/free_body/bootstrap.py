"""Bootstrap samples of tosses: motion simulated by a model from the measured starts, with sensor noise; SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from schemas.measurement import SensorNoise
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.kinds.free_body.tossed_body import BodySimulator
from simgap.recording.recording import Trial


def simulated_motion(simulator: BodySimulator, applied: AppliedBody, series: Series, finer: float) -> Series:
    """The motion that the model makes from the first row of true motion `series`, at its stamps."""
    motion = simulator.rollout(
        applied, series.t_s[None], {name: series.columns[name][:1] for name in simulator.state}, finer
    )
    return Series(series.t_s, {name: values[0] for name, values in motion.items()})


def bootstrap_sample(
    simulator: BodySimulator,
    applied: AppliedBody,
    trials: Sequence[Trial],
    read: Sequence[Series],
    noise: SensorNoise,
    finer: float,
    seed: int,
) -> tuple[Trial, ...]:
    """The trials as the model would have moved from their starts, in steps so many times `finer`, read with noise."""
    rng = np.random.default_rng(seed)

    def shaken(values: FloatArray, size: float | None) -> FloatArray:
        return values + rng.normal(0.0, size or 0.0, values.shape)

    out = []
    for trial, series in zip(trials, read, strict=True):
        seen = applied.reported(simulated_motion(simulator, applied, applied.recovered(series), finer))
        shake = Rotation.from_rotvec(rng.normal(0.0, noise.rotation_rad or 0.0, (len(seen.t_s), 3)))
        turned = Rotation.from_quat(np.roll(seen.columns["quat_wxyz"], -1, axis=1)) * shake
        others = {"v_W": noise.v_mps, "w_B": noise.w_radps, "q": noise.q, "qd": noise.qd}
        out.append(
            replace(
                trial,
                t_s=seen.t_s,
                p=shaken(seen.columns["p"], noise.p_m),
                quat_wxyz=np.roll(turned.as_quat(), 1, axis=1),
                **{n: shaken(seen.columns[n], size) for n, size in others.items() if trial.has(n)},
            )
        )
    return tuple(out)
