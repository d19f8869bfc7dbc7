"""The engine's part of a gap: against its closed form, and where the engine fails."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.engines import REPLAY_ENGINE
from jobs.cell import Limits
from simgap.case import Case, case_of
from simgap.engine_comparison.compare import compare_engines, rollouts_in_engine
from tests.support.measurements import sound

STEP_S, MASS_KG, FORCE_N = 0.01, 2.0, 1.0
SPEC = f"""\
schema_version: 1
name: pushed slide
kind: mechanism
columns: {{t: t, q_axis: position, effort_axis: effort}}
subject: {{joints: [{{name: axis, type: prismatic, mass_kg: {MASS_KG}}}]}}
actuation: {{type: effort}}
simulator: {{step_s: {STEP_S}}}
"""


@pytest.fixture
def slide(tmp_path: Path) -> Case:
    """Six trials under a constant force, the model being right."""
    (tmp_path / "trajectories").mkdir()
    (tmp_path / "measurement.yaml").write_text(SPEC)
    t_s, rng = np.arange(0.0, 1.5, 4e-3), np.random.default_rng(0)
    for k in range(6):
        q = 0.5 * FORCE_N / MASS_KG * t_s**2 + 0.1 * k * t_s + rng.normal(0.0, 1e-6, len(t_s))
        table = np.stack([t_s, q, np.full(len(t_s), FORCE_N)], axis=1)
        file = tmp_path / "trajectories" / f"s{k}.csv"
        np.savetxt(file, table, delimiter=",", header="t,position,effort", comments="")
    return case_of(sound(tmp_path), REPLAY_ENGINE)


def broken(case: Case, name: str) -> Case:
    return Case(case.measurement, case.problem, case.trials, case.joints, f"tests.support.gap.broken_engines:{name}")


def test_the_engines_part_of_a_constant_push_is_that_of_its_steps(slide: Case):
    """An engine moves a body by its speed at the end of a step: after time t it is half a step's speed gain ahead."""
    mechanism = slide.problem.declared_mechanism()
    assert mechanism is not None
    rollouts = rollouts_in_engine(slide, mechanism)
    comparison = compare_engines(rollouts, slide.problem.channels(), slide.problem.channel_units())
    (axis,) = comparison.differences
    since = [t.t_s - t.t_s[0] for t in rollouts.trials]
    ahead = 0.5 * FORCE_N / MASS_KG * STEP_S * np.concatenate(since)
    expected = float(np.sqrt((ahead**2).mean()))
    assert (axis.channel, axis.unit, comparison.failure) == ("q_axis", "m", "")
    assert set(comparison.trials) == set(slide.trials.test)
    assert comparison.engine.step_s == STEP_S
    assert axis.between_engines == pytest.approx(expected, rel=0.03)
    assert axis.between_at_finer_step == pytest.approx(expected / 4.0, rel=0.05)
    assert axis.ours_to_recording < 0.2 * expected  # The model is right: the gap of a user would be the engine's.
    assert axis.engine_to_recording == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize(
    ("name", "words", "seconds"),
    [
        ("RefusingEngine", "no joints of this kind", 60.0),
        ("CrashingEngine", "crashed", 60.0),
        ("EndlessEngine", "after 3 s", 3.0),
    ],
)
def test_an_engine_that_fails_is_reported_and_ends_nothing(
    slide: Case, monkeypatch: pytest.MonkeyPatch, name: str, words: str, seconds: float
):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[3]))
    mechanism = slide.problem.declared_mechanism()
    assert mechanism is not None
    rollouts = rollouts_in_engine(broken(slide, name), mechanism, Limits(seconds=seconds, memory_mb=4096))
    comparison = compare_engines(rollouts, slide.problem.channels(), slide.problem.channel_units())
    assert comparison.differences == ()
    assert comparison.failure.startswith("0 of ")
    assert words in comparison.failure
