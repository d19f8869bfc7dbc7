"""Fits of a law that is not linear in its parameter: values of another optimiser, from few and from rough slopes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from schemas.arrays import FloatArray
from simgap.problem import Model, Term
from simgap.whole_trials import fit_model as module
from simgap.whole_trials.fit_model import ModelFit, fit_model
from simgap.whole_trials.linearisation import Linearisation, linearise
from simgap.whole_trials.losses import losses
from simgap.whole_trials.policy import POLICY
from tests.simgap.whole_trials.drawn_trials import ROWS, TRIALS, Drawn, T, candidates

RATE = 3.0
POLICY_TO_THE_END = replace(POLICY, least_step=1e-4)


class Decaying(Drawn):
    """Decays from free heights at a common rate; `plain` has slopes that are off by a share."""

    def __init__(self, off: float = 0.0) -> None:
        rng = np.random.default_rng(5)
        self.heights = rng.uniform(20.0, 60.0, TRIALS)
        self.off, self.asked = off, 0
        self.readings = self.heights[:, None] * np.exp(-RATE * T)[None] + rng.normal(size=(TRIALS, ROWS))

    @property
    def plain(self) -> Decaying:
        return self if not self.off else _Rough(self)

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        self.asked += 1
        rate = model[0].values["size"]
        return np.stack([s * np.exp(-rate * T)[None] - self.readings for s in starts])


class _Rough(Decaying):
    """The same as errors of a slightly faster clock: slopes differ, the same everywhere."""

    def __init__(self, exact: Decaying) -> None:
        self.readings, self.off, self.asked, self.faster = exact.readings, 0.0, 0, 1.0 + exact.off

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        rate = model[0].values["size"] * self.faster
        return np.stack([s * np.exp(-rate * T)[None] - self.readings for s in starts])


def fitted(system: Decaying, begin: float = 0.5) -> ModelFit:
    (law,) = candidates("ramp")
    model = (Term(replace(law, bounds={"size": (0.0, 20.0)}), {"size": begin}),)
    return fit_model(system, model, system.readings[:, :1].copy(), POLICY_TO_THE_END)


@pytest.fixture(scope="module")
def expected() -> tuple[float, float]:
    """The rate with the least loss, and that loss; of each rate with the heights that fit it best."""
    readings = Decaying().readings

    def loss(rate: float) -> float:
        shape = np.exp(-rate * T)
        errors = (readings @ shape / (shape @ shape))[:, None] * shape[None] - readings
        return float(losses((errors**2).sum(axis=1), np.full(TRIALS, ROWS - 1.0)).sum())

    least = minimize_scalar(loss, bounds=(1.0, 6.0), method="bounded", options={"xatol": 1e-9})
    return float(least.x), float(least.fun)


def test_the_values_are_those_of_another_optimiser(expected: tuple[float, float]) -> None:
    fit = fitted(Decaying())
    assert fit.model[0].values["size"] == pytest.approx(expected[0], abs=1e-3)
    assert fit.losses.sum() == pytest.approx(expected[1], abs=1e-2)


@pytest.mark.parametrize("off", [0.05, -0.05])
def test_rough_slopes_end_at_the_same_values(off: float, expected: tuple[float, float]) -> None:
    """To far below what the noise leaves open: errors are judged in fine steps, slopes in plain ones."""
    fit = fitted(Decaying(off))
    width = module.half_widths(fit, 1.0)[fit.model[0].candidate.key]["size"]
    assert abs(fit.model[0].values["size"] - expected[0]) < 0.1 * width
    assert fit.losses.sum() < expected[1] + 0.05


def test_slopes_serve_for_further_steps_only_while_they_keep_their_promise(
    monkeypatch: pytest.MonkeyPatch, expected: tuple[float, float]
) -> None:
    """Computed less often than at every step."""
    counts: dict[float, int] = {}
    for promise in (module._KEPT_PROMISE, np.inf):
        calls: list[int] = []

        def counted(*given: Any, calls: list[int] = calls) -> Linearisation:
            calls.append(1)
            return linearise(*given)

        with monkeypatch.context() as patched:
            patched.setattr(module, "linearise", counted)
            patched.setattr(module, "_KEPT_PROMISE", promise)
            assert fitted(Decaying()).losses.sum() == pytest.approx(expected[1], abs=1e-2)
        counts[promise] = len(calls)
    assert counts[module._KEPT_PROMISE] < counts[np.inf]
