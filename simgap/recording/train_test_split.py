"""Split of a measurement into training and test trials, by declaration or by rule; always whole trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.measurement import MeasurementSpec

TEST_SHARE = 0.3


@dataclass(frozen=True)
class Trials:
    """Ids of trials to fit on and trials to judge on."""

    train: tuple[str, ...]
    test: tuple[str, ...]


def split_trials(spec: MeasurementSpec, ids: Sequence[str], seed: int = 0) -> Trials:
    """The split that the file declares, else 70:30 by whole trials, two to judge by wherever two are left to teach.

    Order and content do not depend on the machine.

    Raises ValueError with fewer than two trials: one log cannot both teach and judge.
    """
    if spec.split is not None:
        known = set(ids)
        return Trials(tuple(i for i in spec.split.train if i in known), tuple(i for i in spec.split.test if i in known))
    if len(ids) < 2:
        raise ValueError(f"{len(ids)} trial(s); at least 2 are needed")
    order = np.random.default_rng(seed).permutation(len(ids))
    n_test = max(round(TEST_SHARE * len(ids)), min(2, len(ids) // 2))
    test = {ids[k] for k in order[:n_test]}
    return Trials(tuple(i for i in ids if i not in test), tuple(i for i in ids if i in test))
