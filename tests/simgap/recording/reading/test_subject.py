"""A joint table that no mechanism can have is refused, with the numbers, their unit and the line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from schemas.measurement import Joint
from simgap.kinds.mechanism.declared_model import build_mechanism
from simgap.recording.read import read
from tests.support.bad_inputs.gap import HINGE, SAMPLES, swung
from tests.support.measurements import sound


def _with_inertia(folder: Path, words: str) -> Path:
    return swung(spec=HINGE.replace("inertia_kgm2: 0.01, ", words))(folder)


def test_an_inertia_below_that_of_the_load_is_refused_with_both_numbers(tmp_path: Path):
    outcome = read(SAMPLES["gap/inertia-below-load"](tmp_path))
    assert outcome.value is None
    (found,) = [d for d in outcome.diagnostics if d.code == "gap/inertia-below-load"]
    assert (found.value, found.bound, found.unit) == (0.001, pytest.approx(0.2 * 0.1**2), "kg m2")
    assert str(found.where) == "measurement.yaml:6:26"
    assert "com_distance_m" in found.help


def test_a_joint_without_any_inertia_is_refused(tmp_path: Path):
    nothing = HINGE.replace("inertia_kgm2: 0.01, ", "").replace("com_distance_m: 0.1", "com_distance_m: 0")
    outcome = read(swung(spec=nothing)(tmp_path))
    assert [d.code for d in outcome.diagnostics if d.severity == "error"] == ["gap/missing-key"]


@pytest.mark.parametrize(("words", "about_com"), [("inertia_kgm2: 0.01, ", 0.008), ("inertia_kgm2: 0.002, ", 0.0)])
def test_the_declared_inertia_is_simulated_to_the_digit(tmp_path: Path, words: str, about_com: float):
    """A point mass included, at any size: nothing is raised to a least value."""
    measurement = sound(_with_inertia(tmp_path, words))
    (link,) = build_mechanism(measurement.spec, tmp_path).tree
    assert link.inertia_J[1, 1] == pytest.approx(about_com, abs=1e-15)


def test_a_small_mechanism_keeps_its_inertia(tmp_path: Path):
    measurement = sound(_with_inertia(tmp_path, ""))
    small = Joint.model_validate(
        {"name": "hinge", "inertia_kgm2": 3e-10, "gravity_load": {"mass_kg": 1e-4, "com_distance_m": 1e-3}}
    )
    subject = measurement.spec.subject.model_copy(update={"joints": (small,)})
    (link,) = build_mechanism(measurement.spec.model_copy(update={"subject": subject}), tmp_path).tree
    np.testing.assert_allclose(link.inertia_J, 2e-10 * np.eye(3), rtol=1e-9)


def test_a_model_made_without_the_reader_is_refused_too(tmp_path: Path):
    measurement = sound(_with_inertia(tmp_path, ""))
    light = measurement.spec.subject.joints[0].model_copy(update={"inertia_kgm2": 0.001})
    subject = measurement.spec.subject.model_copy(update={"joints": (light,)})
    with pytest.raises(ValueError, match="hinge"):
        build_mechanism(measurement.spec.model_copy(update={"subject": subject}), tmp_path)
