"""The picture of unexplained efforts shows efforts, in the unit of its axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from schemas.sim_gap.extension import Place
from simgap.kinds.mechanism.declared_model import build_mechanism
from simgap.report.pictures.unexplained import unexplained_figure
from tests.support.gap.joint_recordings import SLIDING, TURNING, driven_joint
from tests.support.measurements import sound


@pytest.mark.parametrize(
    ("joint", "inertia", "friction", "units"),
    [(TURNING, 0.02, 0.5, ("N m", "rad/s")), (SLIDING, 95.0, 20.0, ("N", "m/s"))],
)
def test_a_hidden_friction_is_read_off_in_newtons(
    tmp_path: Path, joint: str, inertia: float, friction: float, units: tuple[str, str]
):
    """Dots lie at the friction's own value: accelerations would be 1/inertia times as large."""
    measurement = sound(driven_joint(tmp_path, joint, inertia, friction))
    declared = build_mechanism(measurement.spec, measurement.root)
    where, trials = Place(joint="axis"), measurement.trial_ids
    canvas = unexplained_figure(declared, measurement, (), "joint.coulomb_friction", where, trials)
    assert canvas is not None
    axes = canvas.axes[0]
    assert axes.get_ylabel() == f"unexplained effort ({units[0]})"
    assert axes.get_xlabel() == f"speed ({units[1]})"
    rate, effort = np.array(axes.get_lines()[0].get_data(), dtype=np.float64)
    for direction in (-1.0, 1.0):
        moving = direction * rate > 0.3 * np.abs(rate).max()
        assert np.median(effort[moving]) == pytest.approx(-direction * friction, rel=0.05)
