"""Stretches of trials that roll-outs start from, as arrays over all windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.model import FloatArray, IntArray
from sim.effects.effect import Series
from sim.mechanism import Windows
from simgap.mechanism.smooth import Smooth
from simgap.mechanism.terms import Applied

_COMPARED = 8  # rows per window that are compared


@dataclass(frozen=True)
class Cut:
    """Rows of one trial: (w, k) indices of every window, and (c,) positions in a window that are compared."""

    rows: IntArray
    compared: IntArray


def cut(length: int, rows_per_window: int | None) -> Cut:
    """Windows of so many rows side by side, the last one ending at the trial's end; None: the whole trial as one."""
    if rows_per_window is None or rows_per_window >= length:
        starts, k = np.zeros(1, dtype=int), length
    else:
        k = rows_per_window
        starts = np.arange(0, length - k + 1, k - 1)
    compared = np.unique(np.linspace(1, k - 1, _COMPARED if rows_per_window else 40 * _COMPARED).round().astype(int))
    return Cut(starts[:, None] + np.arange(k), compared)


def windows_of(pieces: Sequence[tuple[Series, Smooth, Cut]], applied: Applied) -> Windows:
    """All windows of all trials; shorter ones are held at their last row, so that time stands still there."""
    longest = max(c.rows.shape[1] for _, _, c in pieces)
    rows = [np.pad(c.rows, ((0, 0), (0, longest - c.rows.shape[1])), mode="edge") for _, _, c in pieces]
    sent = [applied.sent(series) for series, _, _ in pieces]

    def gathered(name: str) -> FloatArray | None:
        if not all(name in s.columns for s in sent):
            return None
        return np.concatenate([s.columns[name][r] for s, r in zip(sent, rows, strict=True)])

    def side_channel(name: str) -> FloatArray:
        return np.concatenate([s.columns[name][r][..., 0] for s, r in zip(sent, rows, strict=True)])

    return Windows(
        t_s=np.concatenate([s.t_s[r] for s, r in zip(sent, rows, strict=True)]),
        q0=np.concatenate([m.q[r[:, 0]] for (_, m, _), r in zip(pieces, rows, strict=True)]),
        qd0=np.concatenate([m.qd[r[:, 0]] for (_, m, _), r in zip(pieces, rows, strict=True)]),
        command=gathered("command"),
        effort=gathered("effort"),
        aux={n[4:]: side_channel(n) for n in sent[0].columns if n.startswith("aux:")},
    )
