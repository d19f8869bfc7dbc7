"""How often a law may repeat over the travel of a joint, for effects that are periodic in the position."""

from __future__ import annotations

import numpy as np

from sim.effects.effect import Scan
from sim.effects.ranges import JointRanges

# Half waves within the range that was reached: below, nothing repeats, and springs and weights do the same.
_REPEATED = 3.0
_FINEST_PHASE = 300.0  # radians of phase over the range: finer waves than rows of a log can follow
_TYPICAL_PHASE = 12.0
_LEAST_TRAVEL = 1e-6  # rad (m)
COUNTS = Scan(40, by_ratio=True)  # of waves that a search probes


def count_bounds(ranges: JointRanges) -> tuple[float, float]:
    """Bounds of `count_per_rad`, 1/rad (1/m)."""
    span = max(ranges.span, _LEAST_TRAVEL)
    return _REPEATED * np.pi / span, _FINEST_PHASE / span


def count_start(ranges: JointRanges) -> float:
    """Initial value of `count_per_rad`."""
    return _TYPICAL_PHASE / max(ranges.span, _LEAST_TRAVEL)
