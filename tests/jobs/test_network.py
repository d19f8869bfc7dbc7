"""A process that left the network reaches no server, and nor does what it starts; its files stay its own.

Whether the system allows it is asked of another program (`tests.support.namespaces`): where it is forbidden nothing may
change, and the function has to say so.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from tests.support.namespaces import network_may_be_left

REACH = (
    "import socket, sys\n"
    "try:\n    socket.create_connection(('127.0.0.1', int(sys.argv[1])), 2).close(); print('reached')\n"
    "except OSError:\n    print('cut off')\n"
)
LEAVE = f"from jobs.network import leave_network\nassert leave_network() is {network_may_be_left()}\n"
AFTER = "cut off" if network_may_be_left() else "reached"


@pytest.fixture
def port() -> Iterator[int]:
    """A server of this machine that takes connections."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def accept() -> None:
            with suppress(OSError):
                while True:
                    server.accept()[0].close()

        threading.Thread(target=accept, daemon=True).start()
        yield server.getsockname()[1]


def output(code: str, *arguments: object) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout.strip()


def test_a_process_reaches_the_server_before_and_not_after(port: int) -> None:
    assert output(REACH, port) == "reached"
    assert output(LEAVE + REACH, port) == AFTER


def test_what_it_starts_is_cut_off_too(port: int) -> None:
    code = f"{LEAVE}import subprocess, sys\nsubprocess.run([sys.executable, '-c', {REACH!r}, sys.argv[1]], check=True)"
    assert output(code, port) == AFTER


def test_files_belong_to_the_same_user(tmp_path: Path) -> None:
    code = f"import os, sys\n{LEAVE}open(sys.argv[1], 'w').close(); print(os.getuid())"
    here = output("import os; print(os.getuid())")
    assert output(code, tmp_path / "made") == here
    assert (tmp_path / "made").stat().st_uid == int(here)
