"""The page of a report: its title, the places of the error, and whose error it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from schemas.sim_gap.report import Baseline, EngineComparison, EngineDifference, GapReport, RolloutEngine, Verdict
from simgap.report.html import render_page

HASH = "0123456789abcdef"
PYBULLET = RolloutEngine(name="PyBullet 1", method="in steps", step_s=0.01)


def report(**more: object) -> GapReport:
    fields: dict[str, object] = {
        "measurement": HASH,
        "n_train": 1,
        "n_test": 1,
        "wall_s": 1.0,
        "baseline": Baseline(metrics={}),
        "verdict": Verdict(status="no_effect", statement="No effect is needed."),
    }
    return GapReport.model_validate(fields | more)


def slider(between_engines: float) -> EngineDifference:
    return EngineDifference(
        channel="q_rail", unit="m", between_engines=between_engines, ours_to_recording=0.4, engine_to_recording=0.5
    )


def test_the_title_is_the_name_that_its_owner_gave(tmp_path: Path):
    page = render_page(report(measurement_name="front door <3>"), tmp_path)
    assert "<title>Sim gap: front door &lt;3&gt;</title>" in page
    assert HASH not in page
    assert f"<title>Sim gap: measurement {HASH[:12]}</title>" in render_page(report(), tmp_path)  # An older report.


def test_an_error_without_a_place_is_said_to_be_spread(tmp_path: Path):
    assert "Spread evenly" in render_page(report(), tmp_path)


@pytest.mark.parametrize(("between", "words"), [(0.1, "25 % of the gap"), (float("inf"), "it diverged")])
def test_the_engines_part_stands_beside_the_gap(tmp_path: Path, between: float, words: str):
    comparison = EngineComparison(engine=PYBULLET, trials=("a",), differences=(slider(between),))
    written = report(rollout=RolloutEngine(name="Mana", method="ours", step_s=0.005), engine_comparison=comparison)
    page = render_page(GapReport.model_validate_json(written.model_dump_json()), tmp_path)
    assert words in page
    assert "PyBullet 1 at the user's step of 10 ms" in page
    assert "5 ms at most" in page


def test_an_engine_that_failed_is_said_to_have(tmp_path: Path):
    comparison = EngineComparison(engine=PYBULLET, failure="0 of 3 trials: crashed")
    page = render_page(report(rollout=PYBULLET, engine_comparison=comparison), tmp_path)
    assert "0 of 3 trials: crashed" in page
