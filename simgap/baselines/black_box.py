"""Baseline that names nothing: a regression on top of a model's short roll-outs; losses of the test trials."""

from __future__ import annotations

from schemas.arrays import FloatArray
from simgap.baselines.residual_regression import corrected
from simgap.inference.losses import trial_losses
from simgap.problem import Model, Problem
from simgap.recording.train_test_split import Trials


def black_box_losses(problem: Problem, model: Model, trials: Trials, scale: FloatArray) -> FloatArray:
    """(n,) losses of the test trials under `model` with a black box on top of it, fitted on the training trials."""
    (teaching, teach), (judging, judged) = (
        (problem.features(ids, "short_horizon"), problem.residuals(model, ids, "short_horizon"))
        for ids in (trials.train, trials.test)
    )
    return trial_losses(corrected(teaching, teach, judging, judged), scale)
