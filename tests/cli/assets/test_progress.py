"""Where no one watches a terminal, an ingest writes a line of progress now and then."""

from __future__ import annotations

from cli.assets.progress import LINE_S, logged_progress
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem


def test_lines_come_at_most_every_half_minute_with_the_tally_of_all_items_so_far() -> None:
    lines: list[str] = []
    now_s = 0.0
    show = logged_progress(lines.append, lambda: now_s)
    show(0, 9, None)
    for done in range(1, 10):
        now_s += LINE_S / 3.0
        outcome = ItemOutcome.REJECTED if done % 2 else ItemOutcome.ACCEPTED
        show(done, 9, ReportItem(source=f"{done}.obj", outcome=outcome))
    assert lines == [
        "mana: 3 of 9 items done: 1 accepted, 2 rejected",
        "mana: 6 of 9 items done: 3 accepted, 3 rejected",
        "mana: 9 of 9 items done: 4 accepted, 5 rejected",
    ]
