"""Cells: a child process ends with a status, its output is kept, and its limits and grandchildren are enforced."""

import subprocess
import sys
import time

from jobs.cell import Limits, run_cell

PYTHON = sys.executable


def run(code: str, seconds: float = 20.0, memory_mb: int = 1024):
    return run_cell([PYTHON, "-c", code], Limits(seconds, memory_mb))


def test_success_and_output():
    result = run("print('hello')")
    assert (result.status, result.returncode, result.output) == ("ok", 0, "hello\n")


def test_plain_failure_keeps_the_last_words():
    result = run("raise SystemExit('broken input')")
    assert result.status == "failed"
    assert "broken input" in result.output


def test_abort_is_a_crash():
    assert run("import os; os.abort()").status == "crashed"


def test_hang_is_stopped_with_its_grandchildren():
    started = time.monotonic()
    marker = "mana_test_grandchild_9731"
    code = (
        "import subprocess, sys, time\n"
        f"subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60) # {marker}'])\n"
        "time.sleep(60)"
    )
    assert run(code, seconds=1.0).status == "timeout"
    assert time.monotonic() - started < 10
    time.sleep(0.2)
    listing = subprocess.run(["ps", "-ewwo", "args"], capture_output=True, text=True, check=True).stdout
    assert marker not in listing


def test_memory_limit():
    assert run("x = bytearray(3 * 2**30)", memory_mb=1024).status == "out_of_memory"
