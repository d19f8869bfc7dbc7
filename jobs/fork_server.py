"""`python -P -m jobs.fork_server PRELOAD REQUESTS_FD CLIENT_FD`: import PRELOAD once, then fork a cell per request.

Also known as a zygote. Forking is safe because the process has one thread, which is checked: forks would otherwise
inherit locks and thread pools of native libraries in an undefined state. A request is a JSON object with a socket and a
log file attached. Over the socket the cell sends its process id, and the server its exit status; when the requesting
process closes it, or dies, the cell is killed. The server ends with its standard input.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import runpy
import selectors
import signal
import socket
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from jobs import warm
from jobs.cell import confine


@dataclass(frozen=True)
class _Cell:
    """A running fork: its process, a descriptor that becomes readable at its end, and the socket of its requester."""

    pid: int
    pidfd: int
    requester: socket.socket


def main(preload: str, requests_fd: int, client_fd: int) -> None:
    """Serve until standard input ends."""
    gc.disable()  # While modules load there is hardly any garbage, and collecting takes a sixth of the time.
    with _one_core():
        importlib.import_module(preload)
    gc.enable()
    threads = len(os.listdir("/proc/self/task"))
    if threads != 1:
        raise SystemExit(f"{preload} left {threads - 1} threads running: forks of it would not be sound")
    os.close(os.pidfd_open(os.getpid()))  # Raises OSError where the system has or allows none.
    gc.freeze()  # Loaded modules are never garbage; untouched, their memory stays shared.
    requests, client = socket.socket(fileno=requests_fd), socket.socket(fileno=client_fd)
    address_space_mb = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE") >> 20
    requests.send(str(address_space_mb).encode())
    selector = selectors.DefaultSelector()
    selector.register(sys.stdin, selectors.EVENT_READ)
    selector.register(requests, selectors.EVENT_READ)
    while True:
        for key, _ in selector.select():
            if key.fileobj is sys.stdin:
                for pid in {k.data.pid for k in selector.get_map().values() if k.data is not None}:
                    _kill(pid)  # Cells die with their parent, see `confine`, but their children do not.
                return
            if key.fileobj is requests:
                message, fds, _, _ = socket.recv_fds(requests, 2**20, 2)
                if not message:
                    return
                requester = socket.socket(fileno=fds[0])
                pid = os.fork()
                if pid == 0:
                    for other in list(selector.get_map().values()):
                        os.close(other.fd)
                    _become_cell(json.loads(message), requester, fds[1], client, address_space_mb)
                os.close(fds[1])
                cell = _Cell(pid, os.pidfd_open(pid), requester)
                selector.register(cell.pidfd, selectors.EVENT_READ, cell)
                selector.register(cell.requester, selectors.EVENT_READ, cell)
            elif key.fileobj is key.data.requester:
                if key.data.requester.fileno() >= 0:  # Else reaped in this same round.
                    selector.unregister(key.data.requester)  # Closed: no process waits for this cell any more.
                    _kill(key.data.pid)
            else:
                _reap(key.data, selector)


@contextmanager
def _one_core() -> Iterator[None]:
    """Within it, libraries that size their thread pools by the cores they may use (TBB) use a single thread."""
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def _reap(cell: _Cell, selector: selectors.BaseSelector) -> None:
    """Report the exit status and peak memory of an ended cell, and kill its remaining processes."""
    _kill(cell.pid)
    _, status, used = os.wait4(cell.pid, 0)
    with suppress(OSError):
        cell.requester.send(f"{os.waitstatus_to_exitcode(status)} {used.ru_maxrss}".encode())
    selector.unregister(cell.pidfd)
    os.close(cell.pidfd)
    with suppress(KeyError):
        selector.unregister(cell.requester)
    cell.requester.close()


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.kill(pid, signal.SIGKILL)  # A cell that has no session yet.
        os.killpg(pid, signal.SIGKILL)


def _become_cell(
    request: dict, requester: socket.socket, log_fd: int, client: socket.socket, address_space_mb: int
) -> NoReturn:
    """Turn this fork into `python -P -m MODULE ARGUMENTS` and run it to its end."""
    code = 1
    try:
        os.setsid()
        confine(request["memory_mb"])
        nothing = os.open(os.devnull, os.O_RDONLY)
        for source, target in ((nothing, 0), (log_fd, 1), (log_fd, 2)):
            os.dup2(source, target)
        requester.send(str(os.getpid()).encode())
        requester.close()
        os.environ.update(request["env"])
        warm.inherit_server(client, address_space_mb)
        sys.argv = [request["module"], *request["arguments"]]
        runpy.run_module(request["module"], run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
        if isinstance(stop.code, str):
            sys.stderr.write(f"{stop.code}\n")
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)  # Not `sys.exit`: the frames of the server lie below.


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
