"""The driver is killed at random moments and started again: nothing is lost, half-written or done twice."""

from __future__ import annotations

import json
import os
import random
import signal
import time
from pathlib import Path

import pytest

from assetkit.library import catalog
from assetkit.library.doctor import examine
from tests.assetkit.batch.small_batch import plain_texts, small_batch

ITEMS = 40


@pytest.mark.parametrize("kills", [pytest.param(4, id="a slice"), pytest.param(20, id="all", marks=pytest.mark.long)])
def test_a_killed_driver_loses_nothing_and_does_nothing_twice(kills: int, tmp_path: Path):
    batch = small_batch(tmp_path, plain_texts(ITEMS), "a_killable_cell")
    draw = random.Random(20261126)
    stored: set[str] = set()
    for _ in range(kills):
        driver = batch.start()
        end = time.monotonic() + draw.uniform(0.3, 1.3)
        while driver.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        if driver.poll() is None:
            os.killpg(driver.pid, signal.SIGKILL)
        driver.communicate()
        assert stored <= set(batch.stored())  # What is finished stays finished.
        stored = set(batch.stored())
        batch.require_no_process()
        assert examine(batch.out).healthy if batch.out.exists() else True
    written = batch.stored()
    answer = batch.run()
    assert (answer["cached"], answer["accepted"]) == (len(written), ITEMS)
    assert {note: stamp for note, stamp in batch.stored().items() if note in written} == written
    assert examine(batch.out).findings == ()
    assert [row["asset_id"] for row in catalog.listing(batch.out)] == sorted(f"part_{n}" for n in range(ITEMS))
    report = json.loads((batch.out / "report.json").read_text())
    assert len(report["items"]) == ITEMS
