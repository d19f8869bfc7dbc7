"""Read a measurement in a test: the value, or what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.diagnostics import Severity
from simgap.recording.read import Measurement, read

STATE = ("t_s", "p", "quat_wxyz", "v_W", "w_B")


def sound(folder: Path) -> Measurement:
    outcome = read(folder)
    assert outcome.value is not None, [d.headline for d in outcome.diagnostics]
    return outcome.value


def codes(folder: Path) -> set[str]:
    """Codes of warnings and errors."""
    return {d.code for d in read(folder).diagnostics if d.severity in (Severity.ERROR, Severity.WARNING)}


def assert_same_motion(a: Measurement, b: Measurement, tolerance: float = 1e-6) -> None:
    assert a.trial_ids == b.trial_ids
    for s, t in zip(a.trials, b.trials, strict=True):
        for name in STATE:
            np.testing.assert_allclose(getattr(s, name), getattr(t, name), atol=tolerance, err_msg=name)
