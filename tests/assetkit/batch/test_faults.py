"""Workers that die, disks that fill, clocks that jump, people who are impatient: the library stays whole.

After each fault: no half-written package is visible, catalog and packages agree, no process is left, and the next run
does no finished work again. The faults are real ones, in processes and file systems of their own.
"""

from __future__ import annotations

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.assetkit.batch.small_batch import DEADLINE_S, SmallBatch, plain_texts, small_batch

CODES = {
    "segfault": "asset/worker-crashed",
    "abort": "asset/worker-crashed",
    "sigkill": "asset/worker-crashed",
    "python": "asset/worker-crashed",
    "loop": "asset/worker-timeout",
    "sleep": "asset/worker-timeout",
    "bomb": "asset/worker-out-of-memory",
}
FILE_BYTES = 10_000  # a limit that the layer of a package exceeds and its record does not


def run_again(batch: SmallBatch, count: int) -> dict[str, object]:
    """The answer of one more run, in which everything that was stored is taken from the store."""
    batch.require_sound()
    before = batch.stored()
    answer = batch.run()
    assert answer["cached"] == len(before)
    assert answer["accepted"] == count
    assert {note: stamp for note, stamp in batch.stored().items() if note in before} == before
    batch.require_sound()
    return answer


def test_a_worker_that_dies_or_never_ends_costs_its_own_item(tmp_path: Path):
    """All faults in one batch; each leaves a child process, which dies as well."""
    texts = plain_texts(4) | {name: f"v 0 0 0 # {name}\n" for name in CODES}
    batch = small_batch(tmp_path, texts, "a_dying_cell")
    answer = batch.run()
    codes = answer["codes"]
    assert isinstance(codes, dict)
    assert {name: codes[name] for name in CODES} == {name: [code] for name, code in CODES.items()}
    assert answer["accepted"] == 4
    batch.require_sound()
    plain = batch.stored()
    assert len(plain) == 4
    for name in CODES:
        (tmp_path / "in" / f"{name}.obj").write_text("v 0 0 0\n")
    mended = batch.run()
    assert (mended["cached"], mended["accepted"]) == (4, len(texts))
    assert {note: stamp for note, stamp in batch.stored().items() if note in plain} == plain
    batch.require_sound()


# Runs in a user namespace of its own, where it may mount. Arguments: mount options, those that mend it, driver command.
IN_NAMESPACE = """
import json, subprocess, sys
from contextlib import suppress
from pathlib import Path
from tests.assetkit.batch.small_batch import SmallBatch
place, options, mended = sys.argv[1:4]
batch = SmallBatch(Path(place), sys.stdin.read())
batch.out.mkdir()
subprocess.run(['mount', '-t', 'tmpfs', '-o', options, 'none', str(batch.out)], check=True)
driver = batch.start()
filler = batch.out / 'filler'
if mended == 'removed':
    batch.wait_for_stored(5)
    with suppress(OSError), filler.open('wb', buffering=0) as file:
        while True:
            file.write(bytes(4096))
printed, errors = driver.communicate(timeout=60)
if mended == 'removed':
    filler.unlink()
else:
    subprocess.run(['mount', '-o', f'remount,{mended}', str(batch.out)], check=True)
batch.require_sound()
before = batch.stored()
answer = batch.run()
after = batch.stored()
batch.require_sound()
same = {note: after[note] for note in before} == before
print(json.dumps(dict(printed=printed, errors=errors, code=driver.returncode, stored=len(before), same=same, **answer)))
"""


def has_namespaces() -> bool:
    """Whether this machine lets a process mount in a user namespace."""
    probe = "mkdir -p {0} && mount -t tmpfs none {0}".format("/tmp")
    return subprocess.run(["unshare", "-rm", "sh", "-c", probe], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize(
    ("options", "mended"),
    [("size=500k", "size=64m"), ("nr_inodes=120", "nr_inodes=5000"), ("size=8m", "removed")],
    ids=["a full disk", "no inodes left", "a disk that another process fills"],
)
def test_a_disk_that_takes_no_more_loses_no_finished_work(options: str, mended: str, tmp_path: Path):
    """A small file system in memory; without namespaces, a limit on the size of files does for all three."""
    count = 30
    batch = small_batch(tmp_path, plain_texts(count), "a_storing_cell")
    if not has_namespaces():
        require_refused_by_limit(batch, count)
        return
    program = [sys.executable, "-c", IN_NAMESPACE, str(tmp_path), options, mended]
    done = subprocess.run(
        ["unshare", "-rm", *program],
        input=batch.name,  # no argument: it is how processes of the batch are known
        env=batch.environment,
        capture_output=True,
        text=True,
        timeout=3 * DEADLINE_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads(done.stdout)
    assert answer["code"] in (0, 2), answer
    assert "Traceback" not in answer["errors"]
    first = json.loads(answer["printed"]) if answer["code"] == 0 else {"codes": {}, "accepted": 0}
    assert {code for codes in first["codes"].values() for code in codes} <= {"asset/storage-failed"}
    assert int(first["accepted"]) < count, "the disk did not fill"
    assert len(answer["printed"].splitlines()) == 1
    assert 0 < answer["stored"] < count
    assert (answer["cached"], answer["accepted"], answer["same"]) == (answer["stored"], count, True)


def test_files_that_cannot_grow_are_an_error_of_the_storage(tmp_path: Path):
    batch = small_batch(tmp_path, plain_texts(6), "a_limited_cell")
    require_refused_by_limit(batch, 6)


def require_refused_by_limit(batch: SmallBatch, count: int) -> None:
    """Under a limit on the size of files (RLIMIT_FSIZE) no package is made, and without it all of them are."""
    driver = subprocess.run(
        batch.argv,
        env=batch.environment,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES)),
    )
    assert "Traceback" not in driver.stderr
    assert driver.returncode in (0, 2), driver.stdout + driver.stderr
    if driver.returncode == 0:
        codes = json.loads(driver.stdout)["codes"]
        assert {code for of_item in codes.values() for code in of_item} == {"asset/storage-failed"}
    assert batch.stored() == {}
    run_again(batch, count)


def test_a_library_on_a_read_only_disk_is_refused_in_one_line(tmp_path: Path):
    batch = small_batch(tmp_path, plain_texts(3), "a_reading_cell")
    batch.run()
    before = batch.stored()
    if has_namespaces():
        mount = 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" && shift 0 && exec "$@"'
        driver = batch.start(["unshare", "-rm", "sh", "-c", mount, str(batch.out), *batch.argv])
    else:
        batch.out.chmod(0o500)  # holds for everybody but root
        driver = batch.start()
    printed, errors = driver.communicate(timeout=DEADLINE_S)
    batch.out.chmod(0o755)
    assert driver.returncode == 2, printed + errors
    assert len(printed.splitlines()) == 1
    assert str(batch.out) in printed
    assert batch.stored() == before
    batch.require_sound()
    run_again(batch, 3)


@pytest.mark.parametrize("group", [False, True], ids=["to the driver", "to its group, as a terminal does"])
def test_two_interrupts_leave_a_library_that_the_next_run_completes(group: bool, tmp_path: Path):
    """The second comes while the driver kills its cells, writes the report or the catalog."""
    count = 24
    batch = small_batch(tmp_path, plain_texts(count), "an_interrupted_cell")
    draw = random.Random(7)
    stored = 0
    for attempt in range(4):
        driver = batch.start()
        batch.wait_for_stored(min(stored + 3, count - 1))
        for _ in range(2):
            if driver.poll() is None:
                (os.killpg if group else os.kill)(driver.pid, signal.SIGINT)
            time.sleep(draw.uniform(0.0, 0.1) * attempt)
        driver.communicate(timeout=DEADLINE_S)
        assert len(batch.stored()) >= stored
        stored = len(batch.stored())
        batch.require_sound()
    run_again(batch, count)


# Put before the modules of the driver and its cells: the clock jumps back by a day at each question.
CLOCK = """
import time
_right, _asked = time.time, [0]
def _jumping():
    _asked[0] += 1
    if _asked[0] == 2: open(__file__ + '.jumped', 'w').close()
    return _right() - 86400.0 * _asked[0]
time.time, time.time_ns = _jumping, lambda: int(1e9 * _jumping())
"""


def test_a_clock_that_jumps_back_changes_nothing(tmp_path: Path):
    """Neither limits nor stores rest on the time of day; sources are from tomorrow and packages from yesterday."""
    results: dict[str, dict[str, bytes]] = {}
    tomorrow, yesterday = time.time() + 86400.0, time.time() - 86400.0
    for name in ("right", "jumping"):
        batch = small_batch(tmp_path / name, plain_texts(4) | {"slow": "v 0 0 0 # sleep\n"}, f"a_{name}_cell")
        if name == "jumping":
            (batch.place / "sitecustomize.py").write_text(CLOCK)
            for source in (batch.place / "in").iterdir():
                os.utime(source, (tomorrow, tomorrow))
        answer = batch.run()
        assert (batch.place / "sitecustomize.py.jumped").exists() == (name == "jumping")
        codes = answer["codes"]
        assert isinstance(codes, dict)
        assert codes["slow"] == ["asset/worker-timeout"]
        assert answer["accepted"] == 4
        for path in batch.out.rglob("*.json"):
            os.utime(path, (yesterday, yesterday))
        (batch.place / "in" / "slow.obj").write_text("v 9 0 0\n")
        run_again(batch, 5)
        files = {p.relative_to(batch.out).as_posix(): p.read_bytes() for p in batch.out.glob("[!.]*/**/*.*")}
        results[name] = files
    assert results["right"] == results["jumping"]


def test_a_source_that_vanishes_mid_run_is_missing_and_the_others_are_made(tmp_path: Path):
    batch = small_batch(tmp_path, plain_texts(12), "a_vanishing_cell")
    driver = batch.start()
    batch.wait_for_stored(2)
    shutil.move(tmp_path / "in" / "part_9.obj", tmp_path / "part_9.obj")
    printed, errors = driver.communicate(timeout=DEADLINE_S)
    assert driver.returncode == 0, printed + errors
    answer = json.loads(printed)
    assert answer["codes"]["part_9"] == ["asset/source-missing"]
    assert answer["accepted"] == 11
    batch.require_sound()
    shutil.move(tmp_path / "part_9.obj", tmp_path / "in" / "part_9.obj")
    run_again(batch, 12)
