"""Runs independent work items on a few threads; each item does its heavy work in a cell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

from jobs.cell import allow_cells, kill_all_cells
from jobs.interrupts import deferred_interrupts

T = TypeVar("T")
R = TypeVar("R")
MOST_THREADS = 1024  # each waits for a cell
LOOK_S = 0.1  # seconds after which an interrupt, and a cluster that has grown, are noticed at the latest


def run_all(work: Callable[[T], R], items: Iterable[T], *, jobs: int | Callable[[], int]) -> Iterator[tuple[T, R]]:
    """Yield `(item, work(item))` as items finish, at most `jobs` at a time; items are drawn lazily.

    A cluster grows and shrinks: `jobs` may be a function, which is called again and again.

    On Ctrl-C running cells are killed, nothing further starts, and KeyboardInterrupt is raised after the threads have
    ended, so that finished items stay finished; see `deferred_interrupts` on when.
    """
    pool = ThreadPoolExecutor(max_workers=MOST_THREADS if callable(jobs) else jobs)  # They start when needed.
    limit = jobs if callable(jobs) else lambda: jobs
    with deferred_interrupts() as interrupted:
        yield from _results(pool, work, iter(items), limit, interrupted)
        if interrupted():  # while the last thread ended
            raise KeyboardInterrupt


def _results(
    pool: ThreadPoolExecutor,
    work: Callable[[T], R],
    source: Iterator[T],
    limit: Callable[[], int],
    interrupted: Callable[[], bool],
) -> Iterator[tuple[T, R]]:
    running: dict[Future[R], T] = {}
    try:
        exhausted = False
        while True:
            if interrupted():
                raise KeyboardInterrupt
            allowed = limit()
            while not exhausted and len(running) < allowed:
                try:
                    item = next(source)
                except StopIteration:
                    exhausted = True
                    break
                running[pool.submit(work, item)] = item
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED, timeout=LOOK_S)
            for future in done:
                yield running.pop(future), future.result()
    except BaseException:
        kill_all_cells()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        allow_cells()  # The stop was for this batch only.
