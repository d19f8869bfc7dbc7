"""Warm cells behave as cold ones in `test_cell.py`, and no state passes from one to the next."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from jobs.cell import Limits, allow_cells, kill_all_cells, peak_memory_mb
from jobs.warm import run_module, warm_cells

PRELOAD = "import os\nhome, touched, cores = os.getpid(), [], len(os.sched_getaffinity(0))\n"
WORKER = """
import os, subprocess, sys, time
import loaded_before
from jobs.cell import Limits
from jobs.warm import run_module
what, *rest = sys.argv[1:]
if what == 'say': print(*rest)
if what == 'home': print(loaded_before.home, os.getppid())
if what == 'touch': loaded_before.touched.append(1); print(len(loaded_before.touched))
if what == 'cores': print(loaded_before.cores, len(os.sched_getaffinity(0)))
if what == 'env': print(os.environ.get(rest[0]))
if what == 'abort': os.abort()
if what == 'exit': raise SystemExit(rest[0])
if what == 'raise': raise KeyError(rest[0])
if what == 'eat': x = bytearray(int(rest[0]) * 2**20); x[::4096] = x[::4096]
if what == 'nest': print(run_module('a_worker', rest, Limits(20.0, 4096)).output)
if what == 'late': print('started', flush=True); time.sleep(float(rest[0])); print(os.getppid())
if what == 'hang':
    subprocess.Popen([sys.executable, '-c', f'import time; time.sleep(60) # {rest[0]}'])
    time.sleep(60)
"""


@pytest.fixture(autouse=True)
def modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`a_worker`, which uses `loaded_before`, importable by cells."""
    (tmp_path / "loaded_before.py").write_text(PRELOAD)
    (tmp_path / "a_worker.py").write_text(WORKER)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    yield
    allow_cells()


def run(*arguments: str, seconds: float = 20.0, memory_mb: int = 4096, **more):
    return run_module("a_worker", arguments, Limits(seconds, memory_mb), **more)


def listing() -> str:
    return subprocess.run(["ps", "-ewwo", "args"], capture_output=True, text=True, check=True).stdout


def wait_until(condition: Callable[[], bool], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.1)


def test_cells_are_forks_of_one_process_and_cold_without_it():
    with warm_cells("loaded_before"):
        homes = {tuple(run("home").output.split()) for _ in range(3)}
    assert len(homes) == 1
    home, parent = homes.pop()
    assert home == parent != str(os.getpid())
    home, parent = run("home").output.split()
    assert home != parent == str(os.getpid())


def test_nothing_passes_from_one_cell_to_the_next():
    with warm_cells("loaded_before"):
        assert [run("touch").output for _ in range(2)] == ["1\n", "1\n"]
        assert run("env", "COLOUR", env={"COLOUR": "red"}).output == "red\n"
        assert run("env", "COLOUR").output == "None\n"


def test_thread_pools_made_while_preloading_see_one_core_and_cells_see_all():
    with warm_cells("loaded_before"):
        assert run("cores").output.split() == ["1", str(len(os.sched_getaffinity(0)))]


def test_endings_are_told_apart():
    with warm_cells("loaded_before"):
        assert (run("say", "hello").status, run("say", "hello").output) == ("ok", "hello\n")
        refused = run("exit", "broken input")
        assert (refused.status, refused.returncode, refused.output) == ("failed", 1, "broken input\n")
        assert "KeyError: 'lost'" in run("raise", "lost").output
        assert run("abort").status == "crashed"
        assert run("eat", "8000").status == "out_of_memory"
        assert run("say", "still here").output == "still here\n"


def test_a_hang_is_stopped_with_its_grandchildren():
    with warm_cells("loaded_before"):
        started = time.monotonic()
        assert run("hang", "mana_test_warm_4411", seconds=1.0).status == "timeout"
        assert time.monotonic() - started < 15
        time.sleep(0.2)
        assert "mana_test_warm_4411" not in listing()


def test_a_cell_of_a_cell_is_warm_too_and_dies_with_the_one_that_asked():
    with warm_cells("loaded_before"):
        home = run("home").output.split()[0]
        assert run("nest", "home").output.split() == [home, home]
        assert run("nest", "hang", "mana_test_warm_4412", seconds=1.5).status == "timeout"
        time.sleep(0.5)
        assert "mana_test_warm_4412" not in listing()


def test_several_at_a_time_each_get_their_own_answer():
    answers: dict[int, str] = {}
    with warm_cells("loaded_before"):
        threads = [
            threading.Thread(target=lambda n=n: answers.update({n: run("say", str(n)).output})) for n in range(8)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert answers == {n: f"{n}\n" for n in range(8)}


def test_stopping_the_batch_stops_warm_cells():
    with warm_cells("loaded_before"):
        run("say", "ready")
        stop = threading.Timer(1.0, kill_all_cells)
        stop.start()
        started = time.monotonic()
        assert run("hang", "mana_test_warm_4413").status == "cancelled"
        assert time.monotonic() - started < 15
        assert run("say", "no more").status == "cancelled"


def test_the_server_ends_with_the_context():
    with warm_cells("loaded_before"):
        home = int(run("home").output.split()[0])
        os.kill(home, 0)
    with pytest.raises(ProcessLookupError):
        os.kill(home, 0)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT], ids=lambda how: how.name)
def test_nothing_outlives_a_batch_that_is_killed(how: signal.Signals):
    code = (
        "import signal\n"
        "from jobs.cell import Limits\n"
        "from jobs.warm import run_module, warm_cells\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # shells start background jobs deaf to it
        "with warm_cells('loaded_before'):\n"
        "    print(run_module('a_worker', ['home'], Limits(20.0, 4096)).output.split()[0], flush=True)\n"
        f"    run_module('a_worker', ['hang', 'mana_test_warm_{how}'], Limits(60.0, 4096))\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as batch:
        assert batch.stdout is not None
        home = int(batch.stdout.readline())
        wait_until(lambda: listing().count(f"mana_test_warm_{how}") >= 2)  # this batch and its grandchild
        batch.send_signal(how)
    wait_until(lambda: f"mana_test_warm_{how}" not in listing())
    wait_until(lambda: not Path(f"/proc/{home}").exists())


@pytest.mark.parametrize(
    "preload",
    [
        "import no_such_module",
        "import os; os.abort()",
        "import threading, time; threading.Thread(target=time.sleep, args=(60,), daemon=True).start()",
    ],
    ids=["does not import", "crashes", "starts a thread"],
)
def test_without_a_sound_server_cells_are_cold(tmp_path: Path, preload: str):
    (tmp_path / "unsound.py").write_text(preload)
    with warm_cells("unsound"):
        assert run("say", "hello").output == "hello\n"
        assert run("home").output.split()[1] == str(os.getpid())


def test_a_server_that_dies_costs_nothing_but_its_warmth():
    with warm_cells("loaded_before"):
        os.kill(int(run("home").output.split()[0]), 9)
        assert run("say", "cold").output == "cold\n"


def test_a_cell_that_loses_its_server_runs_again_cold():
    with warm_cells("loaded_before"):
        home = int(run("home").output.split()[0])
        killer = threading.Timer(1.0, os.kill, (home, 9))
        killer.start()
        first, second = run("late", "2.5").output.split()
        assert (first, second) == ("started", str(os.getpid()))


def test_a_limit_too_small_for_a_fork_is_kept_by_a_cold_cell():
    with warm_cells("loaded_before"):
        assert run("home", memory_mb=512).output.split()[1] == str(os.getpid())
        assert run("eat", "800", memory_mb=512).status == "out_of_memory"


def test_memory_of_warm_cells_counts():
    with warm_cells("loaded_before"):
        before = peak_memory_mb()
        run("eat", str(int(before) + 300))
    assert peak_memory_mb() > before + 250
