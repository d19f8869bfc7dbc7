"""Trials drawn from lines: a free start each, the sum of shapes times the trial's load, noise of one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.effects.effect import Confusable
from simgap.problem import Candidate, DirectEstimate, ImaginedRecording, Leftover, Model
from simgap.whole_trials.ladder import ladder_of
from simgap.whole_trials.policy import POLICY
from simgap.whole_trials.search_models import ModelSearch, search_models

TRIALS, ROWS = 12, 80
T = np.linspace(0.0, 1.0, ROWS)
SHAPES = {"ramp": T, "bow": T * (1.0 - T), "wave": np.sin(9.0 * T), "twin": 2.0 * T * (1.0 - T)}


class Drawn:
    """A `TrialSystem` of lines whose truth is a strength by shape, and what no shape explains (`outside`)."""

    def __init__(self, truth: dict[str, float], outside: float = 0.0, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.loads = 1.0 + rng.random(TRIALS)
        starts = rng.normal(scale=30.0, size=TRIALS)
        wild = outside * np.cos(23.0 * T)[None] * rng.normal(size=(TRIALS, 1))
        self.readings = self._lines(truth, starts) + wild + rng.normal(size=(TRIALS, ROWS))

    def _lines(self, values: dict[str, float], starts: FloatArray) -> FloatArray:
        total = sum((v * SHAPES[n] for n, v in values.items()), np.zeros(ROWS))
        return self.loads[:, None] * total[None] + starts[:, None]

    @property
    def trial_ids(self) -> tuple[str, ...]:
        return tuple(map(str, range(TRIALS)))

    @property
    def start_steps(self) -> FloatArray:
        return np.ones((TRIALS, 1))

    @property
    def channel_count(self) -> int:
        return 1

    @property
    def piece_starts(self) -> tuple[tuple[int, int], ...]:
        return tuple((trial, 0) for trial in range(TRIALS))

    def pieces(self, count: int) -> None:
        return None

    def finer(self) -> Drawn:
        return self

    @property
    def plain(self) -> Drawn:
        return self

    def imagined(self, model: Model) -> tuple[ImaginedRecording, ...]:
        return ()

    def with_noise_from(self, model: Model, starts: FloatArray) -> Drawn:
        return self

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        values: dict[str, float] = {}
        for term in model:
            name = term.candidate.effect.name
            values[name] = values.get(name, 0.0) + term.values["size"]
        return np.stack([self._lines(values, s[:, 0]) - self.readings for s in starts])


class Named:
    """Stands for an effect of a candidate: its name, unit and experiments are read."""

    phase = None

    def __init__(self, name: str, same_as: str = "") -> None:
        self.name = name
        self.confusables = (Confusable(same_as, "another look", True),) if same_as else ()
        self.parameters = (Size(),)


class Size:
    """Stands for the parameter of such an effect."""

    name, unit, scan = "size", "1", None


class DrawnProblem:
    """Stands for a problem: direct estimates by name of the effect."""

    def __init__(
        self,
        direct: dict[str, tuple[float, float]],
        all_candidates: Sequence[Candidate] = (),
        leftovers: tuple[Leftover, ...] = (),
    ) -> None:
        """`direct` values with their standard errors; `leftovers` of the balance, whatever the model."""
        self._direct, self._candidates, self._leftovers = direct, tuple(all_candidates), leftovers

    @property
    def trial_ids(self) -> tuple[str, ...]:
        return tuple(map(str, range(TRIALS)))

    def leftovers(self, model: Model, trials: Sequence[str]) -> tuple[Leftover, ...]:
        return self._leftovers

    def candidates(self) -> tuple[Candidate, ...]:
        return self._candidates

    def channels(self) -> tuple[str, ...]:
        return ("y",)

    def channel_units(self) -> tuple[str, ...]:
        return ("m",)

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        if candidate.effect.name not in self._direct:
            return None
        value, error = self._direct[candidate.effect.name]
        return DirectEstimate({"size": value}, {"size": error}, 1e-6, TRIALS)


def candidates(names: str) -> list[Candidate]:
    none = {"size": 0.0}
    return [
        Candidate(Named(n), Place(), none, none, {"size": (-500.0, 500.0)})  # pyright: ignore[reportArgumentType]
        for n in names.split()
    ]


def searched(system: Drawn, names: str) -> ModelSearch:
    return search_models(ladder_of(system, (), POLICY), candidates(names), POLICY)


def keys(names: str) -> set[str]:
    return {f"{n}@world" for n in names.split()}
