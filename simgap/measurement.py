"""A measurement folder as values: `read(folder)` gives the trials, checked and in our units, or says what is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from schemas.measurement import MeasurementSpec, SensorNoise
from simgap.trial import Impacts, Push, Trial


@dataclass(frozen=True)
class Measurement:
    """What was measured, ready for simulation.

    trials        time series of the kinds `free_body`, `mechanism` and `tracking`, in natural order of their ids.
    impacts, pushes   the records of those two kinds instead.
    joints        names of the measured joints, base to tip: the columns of `Trial.q`.
    noise         one standard deviation of each channel: declared, else estimated, else None.
    content_hash  SHA-256 over every file that was read.
    """

    spec: MeasurementSpec
    trials: tuple[Trial, ...]
    root: Path
    content_hash: str
    joints: tuple[str, ...] = ()
    noise: SensorNoise = SensorNoise()
    impacts: Impacts | None = None
    pushes: tuple[Push, ...] = ()

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """Ids of all trials, pushes or impacts."""
        if self.impacts is not None:
            return self.impacts.ids
        return tuple(p.id for p in self.pushes) or tuple(t.id for t in self.trials)
