"""A plan whose parts do not fit together is refused before anything is drawn or judged."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from runtime_plan import load, sample
from runtime_plan.verify import Judge
from schemas.diagnostics import InvalidInput
from tests.support.bad_inputs.plan import changed

Change = Callable[[dict], None]
STAR = [[0.0, 1.0], [-0.6, -0.8], [0.95, 0.3], [-0.95, 0.3], [0.6, -0.8]]
DENT = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.2], [0.0, 1.0]]


def outline(points: list[list[float]]) -> Change:
    def change(document: dict) -> None:
        document["bodies"][0]["stances"][0]["prisms"][0]["outline_m"] = points

    return change


def package(name: str) -> Change:
    return lambda document: document["bodies"][0].update(package=name, package_hash="0" * 64)


def stances(document: dict) -> None:
    document["combinations"][0]["things"][0]["stances"] = []


@pytest.mark.parametrize(
    "change",
    [
        *(outline(points) for points in (STAR, DENT, DENT[::-1], DENT[:2], [])),
        *(package(name) for name in ("../coin", "/coin", "a/../../coin", "..", "a\\b", "")),
        stances,
    ],
)
def test_it_is_refused_on_loading(change: Change, tmp_path: Path):
    (tmp_path / "plan.json").write_text(changed(change))
    with pytest.raises(InvalidInput) as refused:
        load(tmp_path / "plan.json", tmp_path / "packages")
    assert refused.value.diagnostic.code == "plan/inconsistent"


def test_a_place_that_crosses_itself_is_refused_by_the_judge(tmp_path: Path):
    """The sampler needs no polygons, so that loading does not look at them."""
    document = json.loads(changed(lambda _: None))
    document["combinations"][0]["places"][0][1]["polygon"] = {"outline_m": [[0, 0], [1, 1], [1, 0], [0, 1]]}
    (tmp_path / "plan.json").write_text(json.dumps(document))
    plan = load(tmp_path / "plan.json")
    with pytest.raises(InvalidInput) as refused:
        list(Judge(plan).violations(sample(plan, 4, 0)))
    assert refused.value.diagnostic.code == "plan/inconsistent"
