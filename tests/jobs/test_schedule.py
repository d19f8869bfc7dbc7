"""Scheduling: every item runs once, at most `jobs` at a time, and an exception stops the batch only."""

import sys
import threading
import time

import pytest

from jobs.cell import Limits, run_cell
from jobs.schedule import run_all


def test_every_item_once_and_never_more_than_jobs_at_a_time():
    running, peak, lock = 0, 0, threading.Lock()

    def work(n: int) -> int:
        nonlocal running, peak
        with lock:
            running += 1
            peak = max(peak, running)
        time.sleep(0.01)
        with lock:
            running -= 1
        return n * n

    assert sorted(run_all(work, range(20), jobs=3)) == [(n, n * n) for n in range(20)]
    assert peak <= 3


def test_an_exception_ends_the_run_and_starts_nothing_new():
    started = []

    def work(n: int) -> None:
        started.append(n)
        if n == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(run_all(work, range(1000), jobs=1))
    assert len(started) < 10


def test_a_stopped_batch_does_not_stop_what_comes_after_it():
    def work(_: int) -> None:
        raise RuntimeError

    with pytest.raises(RuntimeError):
        list(run_all(work, range(3), jobs=1))
    assert run_cell([sys.executable, "-c", "print(1)"], Limits(seconds=20.0)).status == "ok"
