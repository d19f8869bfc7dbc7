"""`python -m tests.suites.fuzz.cell TASK.json NOTES.jsonl`: a cell that reads many damaged copies of one seed in turn.

Each case ends by itself, or the kernel ends the cell when its processor time is spent (SIGPROF) or it waits for too
long (SIGALRM), whatever native code does; the driver starts another cell behind it. The notes hold a line when a case
starts and one when it has ended.
"""

from __future__ import annotations

import json
import resource
import shutil
import signal
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import IO

from tests.suites.fuzz.cases import make_case
from tests.suites.fuzz.outside import Watch, make_outside
from tests.suites.fuzz.readers.by_format import READERS
from tests.suites.fuzz.seeds import Seed

WAITING_FACTOR = 4.0  # wall seconds for each second of processor time: other processes may want the processor
_RESET_PEAK = "5"  # proc(5), clear_refs: resets the peak of resident memory


def main(task_file: str, notes_file: str) -> None:
    """Run the cases of the task, one after another."""
    task = json.loads(Path(task_file).read_text())
    seed = Seed(task["format"], Path(task["folder"]), Path(task["file"]))
    place = Path(task["place"])
    with Path(notes_file).open("a") as notes, Watch(make_outside(place / "outside")) as watch:
        for number in task["numbers"]:
            shutil.rmtree(place / "case", ignore_errors=True)
            folder, file, done = make_case(f"{task['stream']}:{number}", seed, place)
            _line(notes, {"start": number, "done": done})
            _line(notes, {"end": number, "done": done, **_read(seed, folder, file, watch, task["seconds"])})


def _read(seed: Seed, folder: Path, file: Path, watch: Watch, seconds: float) -> dict[str, object]:
    watch.events()
    Path("/proc/self/clear_refs").write_text(_RESET_PEAK)
    signal.setitimer(signal.ITIMER_REAL, WAITING_FACTOR * seconds)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    started = time.monotonic()
    try:
        note = asdict(READERS[seed.format](folder, file))
    except MemoryError:
        note = {"codes": ["(out of memory)"], "memory": True}
    wall_s = time.monotonic() - started
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    events = watch.events()
    if events:  # Another process may have looked into the folder: only what happens each time is the reader's.
        READERS[seed.format](folder, file)
        repeated = watch.events()
        events = [event for event in events if event in repeated]
    note["broken"] = [*note.get("broken", []), *(f"outside: {event}" for event in events)]
    return {**note, "wall_s": round(wall_s, 4), "peak_mb": _peak_mb()}


def _peak_mb() -> float:
    """The largest resident memory since it was reset, MiB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    words = next((line.split() for line in lines if line.startswith("VmHWM")), None)
    peak_kb = int(words[1]) if words else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak_kb / 1024, 1)


def _line(notes: IO[str], value: dict[str, object]) -> None:
    notes.write(json.dumps(value) + "\n")
    notes.flush()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
