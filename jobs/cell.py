"""Runs one command in a child process with time and memory limits: a *cell*.

Native libraries may abort, hang or use up memory; inside a cell this does not end the batch.
"""

from __future__ import annotations

import ctypes
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import IO, Literal

Status = Literal["ok", "failed", "crashed", "timeout", "out_of_memory", "cancelled", "lost"]
_PR_SET_PDEATHSIG = 1
_POLL_S = 1.0  # between two questions whether a result is still waited for
_OS_ERROR = re.compile(r"\w*Error: \[Errno \d+\] ")  # How Python prints OSError and its subclasses.
_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None
_STOPPING = threading.Event()
_LIVE: set[int] = set()
_LIVE_LOCK = threading.Lock()
_peak_mb = 0.0  # Largest resident memory of cells that were not children of this process, MiB.


@dataclass(frozen=True)
class Limits:
    """Bounds of one cell: wall-clock seconds and address space in MiB."""

    seconds: float = 300.0
    memory_mb: int = 8192


@dataclass(frozen=True)
class CellResult:
    """How a cell ended: `failed` is a plain non-zero exit, `crashed` a signal, `cancelled` a batch that was stopped,
    `lost` the end of the machine that ran it.

    `output` holds its last 4,000 characters.
    """

    status: Status
    returncode: int
    output: str
    seconds: float

    @property
    def os_error(self) -> str | None:
        """The last line of a Python program that ended with a numbered OSError, None for other endings."""
        last = (self.output.strip().splitlines() or [""])[-1]
        return last if self.status == "failed" and _OS_ERROR.match(last) else None


CANCELLED = CellResult("cancelled", 0, "", 0.0)


def run_cell(
    argv: Sequence[str],
    limits: Limits,
    *,
    env: dict[str, str] | None = None,
    abandoned: Callable[[], bool] | None = None,
) -> CellResult:
    """Run `argv` in its own session and wait; on time-out the whole session is killed, also once it is `abandoned`.

    Never raises for what the child does. Grandchildren die with the session, and a cell started by a cell dies with
    its parent (Linux). Limits never exceed those of the calling process.
    """
    if _STOPPING.is_set():
        return CANCELLED
    with tempfile.TemporaryFile() as log:
        child = subprocess.Popen(
            list(argv),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=lambda: confine(limits.memory_mb),  # the child only; resource is POSIX
            env={**os.environ, **(env or {})},
        )
        return supervise(child.pid, child.wait, limits, log, abandoned)


def supervise(
    pid: int,
    wait: Callable[[float | None], int],
    limits: Limits,
    log: IO[bytes],
    abandoned: Callable[[], bool] | None = None,
) -> CellResult:
    """Wait for the end of a started session `pid`; `wait` returns its exit status or raises TimeoutExpired.

    `abandoned` is called every second; once it returns True, no one waits for the result, and the session is killed.
    """
    started = time.monotonic()
    with _LIVE_LOCK:
        _LIVE.add(pid)
    timed_out = given_up = False
    try:
        if _STOPPING.is_set():  # A session that started while the others were killed.
            _kill_session(pid)
        while not given_up:
            left = limits.seconds - (time.monotonic() - started)
            try:
                returncode = wait(left if abandoned is None else min(left, _POLL_S))
                break
            except subprocess.TimeoutExpired:
                if abandoned is None or left <= _POLL_S:
                    raise
                given_up = abandoned()
    except subprocess.TimeoutExpired:
        timed_out = True
    finally:
        _kill_session(pid)
        returncode = wait(None)
        with _LIVE_LOCK:
            _LIVE.discard(pid)
    log.seek(max(0, log.seek(0, os.SEEK_END) - 4000))
    output = log.read().decode(errors="replace")
    status = "cancelled" if given_up or _STOPPING.is_set() else _status(returncode, output, timed_out)
    return CellResult(status, returncode, output, time.monotonic() - started)


def is_stopping() -> bool:
    """Whether `kill_all_cells` was called and no cell may start."""
    return _STOPPING.is_set()


def allow_cells() -> None:
    """Let cells start again after `kill_all_cells`."""
    _STOPPING.clear()


def kill_all_cells() -> None:
    """Stop every running cell and start no further one; called on Ctrl-C."""
    _STOPPING.set()
    with _LIVE_LOCK:
        pids = tuple(_LIVE)
    for pid in pids:
        _kill_session(pid)


def confine(memory_mb: int) -> None:
    """Limit the memory of this process and its children, and end it with its parent; called at the start of a cell."""
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = memory_mb * 2**20 if hard == resource.RLIM_INFINITY else min(memory_mb * 2**20, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    if _LIBC is not None:  # A cell is a session of its own: without this it would outlive a killed parent (prctl(2)).
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def peak_memory_mb() -> float:
    """The largest resident memory in MiB of this process, its children, and the cells it has started."""
    measured = (resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return max(_peak_mb, *measured)


def note_peak_memory(megabytes: float) -> None:
    """Count a cell that was no child of this process in `peak_memory_mb`."""
    global _peak_mb
    _peak_mb = max(_peak_mb, megabytes)


def _kill_session(pid: int) -> None:
    try:
        os.killpg(pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        return  # The session has already ended.


def _status(returncode: int, output: str, timed_out: bool) -> Status:
    if timed_out:
        return "timeout"
    if returncode == 0:
        return "ok"
    if "MemoryError" in output or "bad_alloc" in output or "Cannot allocate memory" in output:
        return "out_of_memory"
    return "crashed" if returncode < 0 else "failed"
