"""Places of the error: a slice is one only where it clearly holds more error than its share of the readings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from schemas.arrays import FloatArray
from simgap.problem import Candidate, DirectEstimate, Model, Problem, View
from simgap.report.localise_error import localise_error
from simgap.whole_trials.policy import POLICY

ROWS, TRIALS = 300, 8
NAMES = tuple(f"t{k}" for k in range(TRIALS))


class Readings(Problem):
    """Two joints whose errors are `size` noise levels, and `larger` times that where joint 1 is beyond 0.4."""

    horizon_s = 0.2

    def __init__(self, larger: float = 1.0, both: bool = True, seed: int = 0, size: float = 1.0) -> None:
        rng = np.random.default_rng(seed)
        self._features = [rng.uniform(-1.0, 1.0, (ROWS, 5)) for _ in NAMES]
        self._errors = []
        for features in self._features:
            error = rng.normal(0.0, size, (ROWS, 2))
            error[features[:, 0] > 0.4] *= larger if both else np.array([larger, 1.0])
            self._errors.append(error)

    @property
    def trial_ids(self) -> tuple[str, ...]:
        return NAMES

    def candidates(self) -> tuple[Candidate, ...]:
        return ()

    def nuisances(self) -> tuple[Candidate, ...]:
        return ()

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        return None

    def channel_units(self) -> tuple[str, ...]:
        return ("rad", "rad")

    def channels(self) -> tuple[str, ...]:
        return ("q_one", "q_two")

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        return np.ones(2)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        return [self._errors[NAMES.index(t)] for t in trials]

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        return [self._features[NAMES.index(t)] for t in trials]


def places(problem: Problem) -> list[str]:
    return [row.what for row in localise_error(problem, (), NAMES, ("one", "two"))]


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_place(seed: int):
    """Shares of the error differ from those of the readings by chance, in every slice."""
    assert places(Readings(seed=seed)) == []


@pytest.mark.parametrize(("larger", "size"), [(3.0, 1.0), (1e3, 1.0), (3.0, 1e3)])
def test_the_band_with_the_error_is_found_beside_its_share(larger: float, size: float):
    """Where all errors are a thousand noise levels, too: a loss that saturates would see all bands alike."""
    first, *others = localise_error(Readings(larger, both=False, size=size), (), NAMES, ("one", "two"))
    assert first.axis == "one"
    assert first.phase.startswith("positions above")
    assert first.share_of_time == pytest.approx(1.0 / 6.0, abs=0.03)
    assert first.contrast is not None
    assert first.contrast > 5.0
    assert first.share_of_error > 0.5
    assert [row.what for row in others] == ["one"]  # The other joint has none of it.


def test_a_band_that_is_a_little_worse_is_no_place():
    """A tenth more error than elsewhere is real, and of no help."""
    assert places(Readings(np.sqrt(1.1))) == []
    assert POLICY.contrast > 1.1
