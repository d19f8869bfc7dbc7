"""Cases: the levels are those of restarts, the same number gives the same bytes, and a folder holds no truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from schemas.diagnostics import Severity
from simgap.recording.read import read
from tests.suites.gap2.generate.cases import ROUND, CaseFiles, family_of, mechanism_case, write_case
from tests.suites.gap2.generate.causes.cause import Where
from tests.suites.gap2.generate.causes.combinations import TWINS
from tests.suites.gap2.generate.causes.library import LIBRARY, library_cause
from tests.suites.gap2.generate.causes.outside import OUTSIDE
from tests.suites.gap2.generate.plant import Hidden, Trial, observe
from tests.suites.gap2.generate.power import LEVELS, Readings, miss, strength_for
from tests.suites.gap2.generate.rivals import rivals_of
from tests.suites.gap2.generate.scenes import SCENES, draw_plant, draw_recording, rows_of, sizes_of
from tests.suites.gap2.generate.truth import CLOSE, FAMILIES, SAME, Truth

WITH_EFFECT, CONTROL = 16, 0  # a driven slide with a limit; a pendulum as believed


@pytest.fixture(scope="module")
def hiding() -> CaseFiles:
    return mechanism_case(WITH_EFFECT)


def drawn(scene: str, name: str, seed: int = 5):
    rng = np.random.default_rng(seed)
    plant, period = draw_plant(scene, rng)
    recording = draw_recording(plant, period, rng)
    return plant, recording, Where(plant, 0, sizes_of(plant, recording, 0), rng.random(4)), library_cause(name)


def test_a_hundred_numbers_hold_enough_controls_outside_causes_and_twins() -> None:
    counts = {family: ROUND.count(family) / len(ROUND) for family in FAMILIES}
    assert 300 * counts["control"] >= 80
    assert 300 * (counts["outside"] + counts["left_out"] + counts["twin"]) >= 120
    assert {family_of(n) for n in range(20)} == set(FAMILIES)


def test_every_library_name_can_be_hidden_and_every_scene_of_a_cause_exists() -> None:
    for cause in (*LIBRARY, *OUTSIDE):
        assert set(cause.scenes) <= set(SCENES)
    for first, second, scenes in TWINS:
        assert set(scenes) <= set(library_cause(first).scenes)
        assert library_cause(second)


@pytest.mark.parametrize("level", ["large", "gross"])
def test_strength_reaches_its_level_by_restarts_from_the_true_state(level: str) -> None:
    plant, recording, where, cause = drawn("pendulum", "joint.quadratic_drag")

    def miss_at(strength: float, horizon_s: float = recording.horizon_s) -> float:
        readings = observe(plant, cause.hidden(strength, where), recording.trials, recording.step_s)
        return miss(plant, readings, recording.trials, recording.sigma, horizon_s, recording.step_s)

    strength, reached = strength_for(miss_at, LEVELS[level], cause.least, cause.most)
    assert reached
    assert miss_at(strength) == pytest.approx(LEVELS[level], rel=0.05)
    assert miss_at(strength, float("inf")) > 2.0 * LEVELS[level]


def test_restarted_true_model_misses_nothing() -> None:
    plant, recording, _, _ = drawn("chain2", "joint.spring")
    readings = observe(plant, Hidden(), recording.trials, recording.step_s)
    assert miss(plant, readings, recording.trials, recording.sigma, 0.2, recording.step_s) < 1e-3


def test_tilt_of_a_pendulum_is_a_zero_error_of_its_sensor_and_no_spring() -> None:
    plant, recording, where, cause = drawn("pendulum", "joint.axis_tilt")
    recording = replace(recording, trials=recording.trials[:3])

    def readings_at(share: float, trials: Sequence[Trial]) -> Readings:
        return observe(plant, cause.hidden(0.05 * share, where), trials, recording.step_s)

    visible, rivals = rivals_of((cause.name,), where, recording, readings_at)
    assert visible > 100.0
    equal = [r.name for r in rivals if r.noncentrality < SAME]
    assert "sensor.bias" in equal
    assert "joint.spring" not in equal


def test_rivals_are_accepted_up_to_one_bound_and_doubted_up_to_the_next() -> None:
    rivals = {"joint.spring": 0.9 * SAME, "joint.detent": 1.1 * SAME, "sensor.bias": 1.1 * CLOSE}
    truth = Truth(1, "", "single", "mechanism", "pendulum").with_rivals(500.0, rivals)
    assert (truth.accept, truth.near) == (("joint.spring",), ("joint.detent",))
    assert truth.rivals == pytest.approx(rivals, rel=1e-3)


def test_left_out_effect_is_the_hidden_one(hiding: CaseFiles) -> None:
    assert hiding.truth.family == "left_out"
    assert hiding.truth.left_out == tuple(e.name for e in hiding.truth.effects)


def test_same_number_gives_the_same_bytes(hiding: CaseFiles) -> None:
    assert mechanism_case(WITH_EFFECT) == hiding
    assert mechanism_case(CONTROL).files != mechanism_case(CONTROL + 4).files


def test_folder_is_named_by_a_hash_and_holds_no_truth(hiding: CaseFiles, tmp_path: Path) -> None:
    case = hiding
    root = write_case(case, tmp_path)
    assert case.truth.effects
    assert root.name == case.truth.measurement
    assert all(character in "0123456789abcdef" for character in root.name)
    telling = {*FAMILIES, "truth", case.truth.scene, *SCENES, *LEVELS}
    telling |= {name for c in (*LIBRARY, *OUTSIDE) for name in (c.name, c.name.partition(".")[2])}
    named = {p.relative_to(tmp_path).as_posix() for p in root.rglob("*")}
    assert {n.partition("/")[2].partition("/")[0] for n in named} == {"measurement.yaml", "trajectories"}
    headers = " ".join(p.read_text().partition("\n")[0] for p in root.rglob("*.csv"))
    text = (root / "measurement.yaml").read_text() + headers
    assert [word for word in telling - {"slide", "door", "pendulum"} if word in text] == []


def test_reader_takes_a_case_as_it_is_written(hiding: CaseFiles, tmp_path: Path) -> None:
    for case in (hiding, mechanism_case(CONTROL)):
        outcome = read(write_case(case, tmp_path))
        assert [d for d in outcome.diagnostics if d.severity is Severity.ERROR] == []
        assert outcome.value is not None
        assert len(outcome.value.trials) == case.truth.log["trials"]


def test_recordings_are_those_of_users() -> None:
    rates, lengths, counts = [], [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        plant, period = draw_plant(SCENES[seed % len(SCENES)], rng)
        recording = draw_recording(plant, period, rng)
        rates.append(recording.rate_hz)
        lengths += [float(np.ptp(t.stamps_s)) for t in recording.trials]
        counts.append(len(recording.trials))
        assert np.all((plant.mass >= 0.005) & (plant.mass <= 50.0))
        assert rows_of(recording.trials) < 12000
    assert min(rates) >= 30.0
    assert max(rates) <= 1000.0
    assert min(counts) >= 6
    assert max(counts) <= 30
    assert min(lengths) > 0.9
    assert max(lengths) < 10.1
