"""Run one command in a child process with time and memory limits: a *cell* (design: scale).

Native libraries abort, hang and eat memory; inside a cell they cannot take the batch with them.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Status = Literal["ok", "failed", "crashed", "timeout", "out_of_memory"]
_LIVE: set[int] = set()
_LIVE_LOCK = threading.Lock()


@dataclass(frozen=True)
class Limits:
    """Bounds of one cell: wall-clock seconds and address space in MiB."""

    seconds: float = 300.0
    memory_mb: int = 8192


@dataclass(frozen=True)
class CellResult:
    """How a cell ended. `failed` is a plain non-zero exit, `crashed` a signal; `output` its last 4,000 characters."""

    status: Status
    returncode: int
    output: str
    seconds: float


def run_cell(argv: Sequence[str], limits: Limits, *, env: dict[str, str] | None = None) -> CellResult:
    """Run `argv` in its own session and wait; on time-out the whole session is killed.

    Never raises for what the child does. Grandchildren die with the session.
    """
    started = time.monotonic()
    with tempfile.TemporaryFile() as log:
        child = subprocess.Popen(
            list(argv),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=lambda: _limit_memory(limits.memory_mb),  # the child only; resource is POSIX
            env={**os.environ, **(env or {})},
        )
        with _LIVE_LOCK:
            _LIVE.add(child.pid)
        timed_out = False
        try:
            child.wait(timeout=limits.seconds)
        except subprocess.TimeoutExpired:
            timed_out = True
        finally:
            _kill_session(child.pid)
            child.wait()
            with _LIVE_LOCK:
                _LIVE.discard(child.pid)
        log.seek(max(0, log.seek(0, os.SEEK_END) - 4000))
        output = log.read().decode(errors="replace")
    return CellResult(
        _status(child.returncode, output, timed_out), child.returncode, output, time.monotonic() - started
    )


def kill_all_cells() -> None:
    """Stop every running cell; called on Ctrl-C."""
    with _LIVE_LOCK:
        pids = tuple(_LIVE)
    for pid in pids:
        _kill_session(pid)


def _limit_memory(memory_mb: int) -> None:
    limit = memory_mb * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


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
