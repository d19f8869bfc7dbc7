"""A slice of the injected mistakes: all are noticed at their line, two at once give two reports, sound ones pass."""

from __future__ import annotations

from pathlib import Path

import pytest

from schemas.diagnostics import any_error
from tests.suites.pipeline_faults.faults import kinds
from tests.suites.pipeline_faults.programs import program
from tests.suites.pipeline_faults.run import checked, outcomes

LEAST_KINDS, LEAST_AT_LINE = 60, 0.99
PAIRS = (
    ("timeout that is negative", "unknown robot"),
    ("unknown predicate", "radius of zero"),
    ("misspelt key score", "unknown assembly"),
    ("edge to nowhere", "mode that does not exist"),
)


def test_mistakes_of_every_kind_are_noticed_at_their_line(tmp_path: Path) -> None:
    assert len(kinds()) >= LEAST_KINDS
    rows = list(outcomes(1, tmp_path, seed=7))
    assert {row.kind for row in rows} == set(kinds())
    assert [row.kind for row in rows if not row.noticed] == []
    assert sum(row.at_line for row in rows) >= LEAST_AT_LINE * len(rows)


@pytest.mark.parametrize("seed", range(8))
def test_a_sound_pipeline_is_not_refused(seed: int, tmp_path: Path) -> None:
    assert not any_error(checked(program(seed), tmp_path))


@pytest.mark.parametrize(("one", "other"), PAIRS)
def test_two_mistakes_give_two_reports(one: str, other: str, tmp_path: Path) -> None:
    table = kinds()
    first = next(table[one](program(3).split("\n")))
    second = next(table[other](first.text.split("\n")))
    lines = {each.where.line for each in checked(second.text, tmp_path) if any_error([each])}
    assert {first.line, second.line} <= lines
