"""Run a command and measure the processor time and memory of everything it starts."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

_SAMPLE_S = 0.5


@dataclass(frozen=True)
class Cost:
    """What a command took, with all its descendants.

    cpu_s        user and system time.
    process_mb   the largest resident memory of any one process (MiB, sampled high-water marks, shared pages in full).
    together_mb  the largest sum over all of them at a time, shared pages counted once (proportional set size, sampled).
    """

    cpu_s: float
    wall_s: float
    process_mb: float
    together_mb: float
    returncode: int
    output: str


def run(argv: Sequence[str], *, env: dict[str, str], cpu_limit_s: int = 0, wall_limit_s: float = 1800.0) -> Cost:
    """Run `argv` to its end or its limits; `cpu_limit_s` bounds each process (0: not at all), SIGXCPU ends it.

    Processor time of grandchildren counts as far as their parents waited for them.
    """
    started = time.monotonic()
    with tempfile.TemporaryFile() as log:
        child = subprocess.Popen(
            list(argv),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, **env},
            preexec_fn=lambda: _bound(cpu_limit_s),
        )
        process_mb = together_mb = 0.0
        while True:
            pid, status, used = os.wait4(child.pid, os.WNOHANG)
            if pid:
                break
            time.sleep(_SAMPLE_S if together_mb else 0.02)
            now = _memory_mb(child.pid)
            process_mb, together_mb = max(process_mb, now[0]), max(together_mb, now[1])
            if time.monotonic() - started > wall_limit_s:
                os.killpg(child.pid, signal.SIGKILL)
        child.returncode = os.waitstatus_to_exitcode(status)
        log.seek(max(0, log.seek(0, os.SEEK_END) - 4000))
        return Cost(
            cpu_s=used.ru_utime + used.ru_stime,
            wall_s=time.monotonic() - started,
            process_mb=process_mb,  # Not `ru_maxrss`: it begins with the memory of the process that forked.
            together_mb=together_mb,
            returncode=child.returncode,
            output=log.read().decode(errors="replace"),
        )


def _bound(cpu_limit_s: int) -> None:
    if cpu_limit_s:
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_limit_s, cpu_limit_s + 5))


def _memory_mb(pid: int) -> tuple[float, float]:
    """The largest high-water mark of a process and its descendants, and their proportional memory together."""
    largest_kb, total_kb = 0, 0
    with contextlib.suppress(psutil.Error):
        parent = psutil.Process(pid)
        for process in (parent, *parent.children(recursive=True)):
            with contextlib.suppress(OSError):
                largest_kb = max(largest_kb, _kb(process.pid, "status", "VmHWM:"))
                total_kb += _kb(process.pid, "smaps_rollup", "Pss:")
    return largest_kb / 1024, total_kb / 1024


def _kb(pid: int, file: str, key: str) -> int:
    for line in Path(f"/proc/{pid}/{file}").read_text().splitlines():
        if line.startswith(key):
            return int(line.split()[1])
    return 0
