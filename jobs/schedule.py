"""Runs independent work items on a few threads; each item does its heavy work in a cell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

from jobs.cell import allow_cells, kill_all_cells

T = TypeVar("T")
R = TypeVar("R")
MOST_THREADS = 1024  # each waits for a cell


def run_all(work: Callable[[T], R], items: Iterable[T], *, jobs: int | Callable[[], int]) -> Iterator[tuple[T, R]]:
    """Yield `(item, work(item))` as items finish, at most `jobs` at a time; items are drawn lazily.

    A cluster grows and shrinks: `jobs` may be a function, which is called again and again.

    On KeyboardInterrupt running cells are killed, nothing further starts, and the interrupt is raised again after
    the threads have ended, so that finished items stay finished.
    """
    source = iter(items)
    running: dict[Future[R], T] = {}
    limit = jobs if callable(jobs) else lambda: jobs
    pool = ThreadPoolExecutor(max_workers=MOST_THREADS if callable(jobs) else jobs)  # They start when needed.
    try:
        exhausted = False
        while True:
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
            done, _ = wait(running, return_when=FIRST_COMPLETED, timeout=0.5)
            for future in done:
                yield running.pop(future), future.result()
    except BaseException:
        kill_all_cells()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        allow_cells()  # The stop was for this batch only.
