"""Windows of trials that roll-outs start from, as arrays over all windows; SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray, IntArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import Windows
from simgap.kinds.mechanism.apply_model import Applied

_JOINT_ROWS_COMPARED = 8  # rows per window that are compared


@dataclass(frozen=True)
class Cut:
    """Rows of one trial: (w, k) indices of every window, and (c,) positions in a window that are compared."""

    rows: IntArray
    compared: IntArray

    def of(self, values: FloatArray) -> FloatArray:
        """(w, c, ...) what is compared of values (w, k, ...) along windows; later ones are padding."""
        return values[:, self.compared]


def cut(length: int, rows_per_window: int | None, margin: int = 0, most: int = 10**9) -> Cut:
    """Windows of so many rows side by side, `margin` rows from either end; None: the whole trial as one.

    Of more than `most` that many are kept, evenly over the trial.
    """
    inner = length - 2 * margin
    if rows_per_window is None or rows_per_window >= inner:
        margin = margin if inner > 8 else 0
        starts, k = np.array([margin]), length - 2 * margin
    else:
        k = rows_per_window
        starts = np.arange(margin, length - margin - k + 1, k - 1)
        if len(starts) > most:
            starts = starts[np.unique(np.linspace(0, len(starts) - 1, most).round().astype(int))]
    compared = np.unique(
        np.linspace(1, k - 1, _JOINT_ROWS_COMPARED if rows_per_window else 40 * _JOINT_ROWS_COMPARED)
        .round()
        .astype(int)
    )
    return Cut(starts[:, None] + np.arange(k), compared)


def windows_of(pieces: Sequence[tuple[Series, Cut]], applied: Applied) -> Windows:
    """All windows of all trials; shorter ones are held at their last row, so that time stands still there."""
    longest = max(c.rows.shape[1] for _, c in pieces)
    rows = [np.pad(c.rows, ((0, 0), (0, longest - c.rows.shape[1])), mode="edge") for _, c in pieces]
    by_series = {id(series): applied.sent(series) for series, _ in {id(p[0]): p for p in pieces}.values()}
    sent = [by_series[id(series)] for series, _ in pieces]

    def gathered(name: str) -> FloatArray | None:
        if not all(name in s.columns for s in sent):
            return None
        return np.concatenate([s.columns[name][r] for s, r in zip(sent, rows, strict=True)])

    def side_channel(name: str) -> FloatArray:
        return np.concatenate([s.columns[name][r][..., 0] for s, r in zip(sent, rows, strict=True)])

    return Windows(
        t_s=np.concatenate([s.t_s[r] for s, r in zip(sent, rows, strict=True)]),
        q0=np.concatenate([s.columns["q"][r[:, 0]] for s, r in zip(sent, rows, strict=True)]),
        qd0=np.concatenate([s.columns["qd"][r[:, 0]] for s, r in zip(sent, rows, strict=True)]),
        command=gathered("command"),
        effort=gathered("effort"),
        aux={n[4:]: side_channel(n) for n in sent[0].columns if n.startswith("aux:")},
    )
