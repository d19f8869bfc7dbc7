"""Two candidates compared by what their direct estimates leave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simgap.inference.direct_comparison import is_better
from simgap.problem import DirectEstimate


def test_a_route_leads_by_what_it_leaves_or_does_not():
    """A truth value of its own kind would be neither: what the direct route preferred went unheard by that once."""
    estimate = DirectEstimate({}, {}, 0.0, 4, np.array([1.0, 2.0, 3.0, 2.5]))
    better = replace(estimate, held_out=np.array([0.5, 1.1, 1.4, 1.2]))
    led, trailed = is_better(better, estimate), is_better(estimate, better)
    assert led is not None
    assert trailed is not None
    assert (led.kept, trailed.kept) == (True, False)
    assert is_better(better, replace(estimate, held_out=None)) is None
