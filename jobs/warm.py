"""Warm cells: forks of one process that has already imported the needed modules (Linux; elsewhere every cell is cold).

A warm cell is a process and session of its own with limits, and inherits nothing from earlier cells. The seconds of
importing are spent once for a batch instead of once for an asset.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import IO, Protocol

from jobs.cell import CellResult, Limits, note_peak_memory, run_cell, supervise

HEADROOM_MB = 1024  # Least address space beyond that of the server in which a fork of it can work.
_STARTUP_TIMEOUT_S = 120.0
_runner: Runner | None = None


class Runner(Protocol):
    """Runs modules in cells: a fork server of this machine, or a cluster (`jobs.cluster`)."""

    def run(self, name: str, arguments: Sequence[str], limits: Limits, env: dict[str, str]) -> CellResult | None:
        """How the cell ended; None when it has to be run cold, on this machine."""
        ...


def run_module(name: str, arguments: Sequence[str], limits: Limits, *, env: dict[str, str] | None = None) -> CellResult:
    """Run `python -P -m NAME ARGUMENTS` in a cell: warm inside `warm_cells`, on a cluster inside `cluster_cells`, else
    as `jobs.cell.run_cell` does.
    """
    if _runner is not None:
        result = _runner.run(name, arguments, limits, env or {})
        if result is not None:
            return result
    return run_cold(name, arguments, limits, env or {})


def run_cold(
    name: str,
    arguments: Sequence[str],
    limits: Limits,
    env: dict[str, str],
    *,
    abandoned: Callable[[], bool] | None = None,
) -> CellResult:
    """Run `python -P -m NAME ARGUMENTS` in a cell that starts a Python of its own."""
    return run_cell([sys.executable, "-P", "-m", name, *arguments], limits, env=env, abandoned=abandoned)


@contextlib.contextmanager
def use_runner(runner: Runner | None) -> Iterator[None]:
    """Within it, `run_module` runs its cells by `runner`. Not reentrant."""
    global _runner
    _runner = runner
    try:
        yield
    finally:
        _runner = None


@contextlib.contextmanager
def warm_cells(preload: str, *, env: dict[str, str] | None = None) -> Iterator[None]:
    """Within it, `run_module` forks its cells from a process that has imported the module `preload`.

    The process is started by the first cell, with `env` added to the environment, and ends with the context. Where it
    cannot work (no Linux, `preload` does not import or starts threads) cells are cold. Not reentrant.
    """
    server = ForkServer(preload, env or {}) if preload and sys.platform == "linux" else None
    try:
        with use_runner(server):
            yield
    finally:
        if server is not None:
            server.close()


def inherit_server(requests: socket.socket, address_space_mb: int) -> None:
    """Let the cells that this fresh fork runs come from the same server."""
    global _runner
    server = ForkServer("", {})
    server.requests, server.address_space_mb = requests, address_space_mb
    _runner = server


class ForkServer:
    """The client of a fork server. `requests` is the socket to it, None before the first cell and without a server."""

    def __init__(self, preload: str, env: dict[str, str]) -> None:
        self.requests: socket.socket | None = None
        self.address_space_mb = 0
        self._preload, self._env = preload, env
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def run(
        self,
        name: str,
        arguments: Sequence[str],
        limits: Limits,
        env: dict[str, str],
        *,
        abandoned: Callable[[], bool] | None = None,
    ) -> CellResult | None:
        """How the cell ended; None when it has to be run cold. `abandoned` is that of `jobs.cell.supervise`."""
        with self._lock:
            if self.requests is None and self._process is None and self._preload:
                self._start()
        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        memory_mb = limits.memory_mb if soft == resource.RLIM_INFINITY else min(limits.memory_mb, soft >> 20)
        if self.requests is None or memory_mb < self.address_space_mb + HEADROOM_MB:
            return None
        request = {"module": name, "arguments": list(arguments), "memory_mb": memory_mb, "env": env}
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with ours, tempfile.TemporaryFile() as log:
            with theirs:
                try:
                    socket.send_fds(self.requests, [json.dumps(request).encode()], [theirs.fileno(), log.fileno()])
                except OSError:  # The server has ended, for example for lack of memory.
                    self.requests = None
                    return None
            return _supervised(ours, limits, log, abandoned)

    def _start(self) -> None:
        """Start the server and wait until it has imported everything."""
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        fds = (theirs.fileno(), ours.fileno())
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "jobs.fork_server", self._preload, *map(str, fds)],
            stdin=subprocess.PIPE,  # Closed when this process ends, which ends the server.
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=fds,
            start_new_session=True,  # Ctrl-C is for the batch, which then closes the server.
            env={**os.environ, **self._env},
        )
        theirs.close()
        ours.settimeout(_STARTUP_TIMEOUT_S)
        with contextlib.suppress(OSError):
            if ready := ours.recv(64):
                ours.settimeout(None)
                self.requests, self.address_space_mb = ours, int(ready)
                return
        ours.close()

    def close(self) -> None:
        """End the server and with it all its cells."""
        if self.requests is not None:
            self.requests.close()
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()
            self._process.wait()


def _supervised(
    cell: socket.socket, limits: Limits, log: IO[bytes], abandoned: Callable[[], bool] | None
) -> CellResult | None:
    """Follow the cell at the other end of `cell`: its process id, then its exit status and peak memory.

    None when the server ended first and took the cell with it: no fault of the cell, so it may be run cold.
    """

    def wait(seconds: float | None) -> int:
        cell.settimeout(seconds)
        try:
            ending = endings[0] if endings else cell.recv(64)
        except TimeoutError:
            raise subprocess.TimeoutExpired([], seconds or 0.0) from None
        endings[:] = [ending]
        returncode, peak_kb = (int(word) for word in ending.split()) if ending else (-signal.SIGKILL, 0)
        note_peak_memory(peak_kb / 1024)
        return returncode

    endings: list[bytes] = []
    pid = cell.recv(64)
    result = supervise(int(pid), wait, limits, log, abandoned) if pid else None
    return None if endings == [b""] and result is not None and result.status == "crashed" else result
