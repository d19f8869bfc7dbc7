"""Ctrl-C that waits for a safe point: an exception raised between any two instructions can leave a lock taken for ever.

`threading.Condition`, on which thread pools and futures rest, is written in Python: where a second Ctrl-C arrives while
the first one unwinds through it, its lock stays taken and all threads wait for one another.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

_INSISTENT = 4  # presses after which the exception is raised wherever the program is


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], bool]]:
    """Defers Ctrl-C: it raises nothing at first; the yielded function returns whether one came, so that a caller stops.

    The fourth press raises KeyboardInterrupt at once. Threads other than the main one, and programs with a way of their
    own to take SIGINT, are left as they are.
    """
    presses = 0

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal presses
        presses += 1
        if presses >= _INSISTENT:
            raise KeyboardInterrupt

    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: presses > 0
    finally:
        with suppress(ValueError):  # a generator that another thread closes
            signal.signal(signal.SIGINT, signal.default_int_handler)
