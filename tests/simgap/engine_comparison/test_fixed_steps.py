"""A recording at another rate than the simulation: inputs are held, motion is read between the steps."""

from __future__ import annotations

import numpy as np
import pytest

from sim.dynamics.mechanism import Windows
from simgap.engine_comparison.fixed_steps import at_stamps, on_fixed_steps

T_S = np.array([0.0, 0.01, 0.02, 0.03])
INPUTS = np.array([1.0, 2.0, 3.0, 4.0])


def window(t_s: np.ndarray = T_S) -> Windows:
    start = np.zeros((1, 1))
    return Windows(t_s[None], start, start, effort=INPUTS[None, :, None], aux={"supply_V": INPUTS[None]})


@pytest.mark.parametrize(
    ("step_s", "held"), [(0.004, [1, 1, 1, 2, 2, 3, 3, 3, 4]), (0.01, [1, 2, 3, 4]), (0.02, [1, 3, 4]), (0.1, [1, 4])]
)
def test_an_input_counts_from_the_first_step_after_its_stamp(step_s: float, held: list[int]):
    steps = on_fixed_steps(window(), step_s)
    np.testing.assert_allclose(np.diff(steps.t_s[0]), step_s)
    assert steps.t_s[0, -1] >= T_S[-1] - 1e-9
    assert steps.effort is not None
    assert steps.effort[0, :, 0].tolist() == held
    assert steps.aux["supply_V"][0].tolist() == held


def test_motion_at_a_stamp_lies_between_its_steps():
    steps = on_fixed_steps(window(T_S + 5.0), 0.004)
    q = 3.0 * (steps.t_s - 5.0)[..., None]
    np.testing.assert_allclose(at_stamps(steps, q, T_S + 5.0)[:, 0], 3.0 * T_S, atol=1e-12)
