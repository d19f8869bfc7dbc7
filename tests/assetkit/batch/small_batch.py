"""A batch of small packages in a process of its own, for tests that damage or end it: driver, worker and checks."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assetkit.library import catalog
from assetkit.library.doctor import examine
from assetkit.package.record import RECORD, read_record
from jobs.cache import changed_files

SAMPLE = Path(__file__).parents[2] / "data" / "record.json"
ITEM_S = 0.08
DEADLINE_S = 60.0  # of whole drivers; nothing here takes more than a few seconds on an idle machine
# What the text of a source makes its worker do, before it has written a package, each with a child process at its side.
FAULTS = """
def fault(text):
    import ctypes, os, signal, subprocess, sys, time
    if '#' not in text: return
    child = [sys.executable, '-c', 'import time; time.sleep(300)', '{name}']
    subprocess.Popen(child, start_new_session='session' in text)
    if 'segfault' in text: ctypes.string_at(8)
    if 'abort' in text: os.abort()
    if 'sigkill' in text: os.kill(os.getpid(), signal.SIGKILL)
    if 'loop' in text:
        while True: pass
    if 'bomb' in text: hold = [bytes(2**26) for _ in range(2**20)]
    if 'python' in text: raise RuntimeError('a defect')
    time.sleep(300)
"""
CELL = (
    FAULTS
    + f"""
import json, sys, time
from pathlib import Path
from assetkit.batch import result_store
from assetkit.batch.item_cells import candidate_of
from assetkit.package.release import publish
from jobs.cache import file_sha256
from schemas.report import ReportItem
if __name__ == '__main__':
    request = json.loads(Path(sys.argv[1]).read_text())
    candidate, out = candidate_of(request), Path(request['out'])
    name = candidate.asset_id
    folder = Path(request['work_dir']) / 'package' / name
    (folder / 'usd').mkdir(parents=True)
    fault(candidate.file.path.read_text())
    time.sleep({ITEM_S})
    layer = folder / 'usd' / 'layer.usda'
    layer.write_text('#usda 1.0' + chr(10) * 20000)
    record = json.loads(Path({str(SAMPLE)!r}).read_text())
    record |= {{'asset_id': name, 'hashes': {{'usd/layer.usda': file_sha256(layer)}}}}
    (folder / 'record.json').write_text(json.dumps(record))
    publish(folder, out / name)
    item = ReportItem(source=candidate.given, outcome='accepted', packages=(name,))
    result_store.write_stored(Path(request['note']), result_store.stored_from(item, candidate, out))
"""
)
DRIVER = """
import json, sys
from pathlib import Path
from unittest import mock
from assetkit.batch import run_batch
from assetkit.batch.item_cells import Batch
from functools import partial
from jobs.cell import Limits
from jobs.lock import FolderUnusable
from jobs.placement import Placement
if __name__ == '__main__':
    with mock.patch.object(run_batch, 'Batch', partial(Batch, worker='{name}', preload='{name}')):
        limits = Limits(seconds=4.0, memory_mb=4096)
        try:
            done = run_batch.ingest(
                [Path(sys.argv[1])], Path(sys.argv[2]), engine='no:engine', placement=Placement(2), limits=limits
            )
        except FolderUnusable as unusable:
            print(unusable)
            raise SystemExit(2)
        codes = {{Path(item.source).stem: item.codes for item in done.items}}
        print(json.dumps({{**done.totals, 'codes': codes, 'interrupted': done.interrupted}}))
"""


@dataclass(frozen=True)
class SmallBatch:
    """Sources in `place/in`, their library in `place/out`; processes of it are known by `name`."""

    place: Path
    name: str

    @property
    def out(self) -> Path:
        """The library."""
        return self.place / "out"

    @property
    def argv(self) -> list[str]:
        """The command that runs the batch."""
        return [sys.executable, str(self.place / "driver.py"), str(self.place / "in"), str(self.out)]

    @property
    def environment(self) -> dict[str, str]:
        """The environment in which the command finds its worker."""
        return {**os.environ, "PYTHONPATH": os.pathsep.join([str(self.place), *sys.path])}

    def start(self, argv: Sequence[str] | None = None) -> subprocess.Popen[str]:
        """The running driver, in a session of its own."""
        pipe = subprocess.PIPE
        return subprocess.Popen(
            argv or self.argv, env=self.environment, stdout=pipe, stderr=pipe, text=True, start_new_session=True
        )

    def run(self) -> dict[str, object]:
        """What a driver that ends by itself prints."""
        driver = self.start()
        printed, errors = driver.communicate(timeout=DEADLINE_S)
        assert driver.returncode == 0, printed + errors
        answer: dict[str, object] = json.loads(printed)
        return answer

    def stored(self) -> dict[str, int]:
        """The finished results with their times of writing (ns): a result that is made again has another time."""
        notes = (self.out / ".cache" / "items").glob("[!.]*.json")
        return {n.name: n.stat().st_mtime_ns for n in notes if '"outcome":"accepted"' in n.read_text()}

    def wait_for_stored(self, count: int) -> None:
        """Until that many results are stored."""
        end = time.monotonic() + DEADLINE_S
        while len(self.stored()) < count:
            assert time.monotonic() < end, "the batch makes no progress"
            time.sleep(0.01)

    def require_sound(self) -> None:
        """No process is left, every visible folder is a whole package, and catalog and packages agree."""
        self.require_no_process()
        for folder in sorted(p for p in self.out.glob("[!.]*") if p.is_dir()):
            record = read_record(folder)
            assert record is not None, f"{folder.name} has no record"
            assert changed_files(folder, record.hashes) == []
        assert examine(self.out).healthy
        packages = sorted(path.parent.name for path in self.out.glob(f"[!.]*/{RECORD}"))
        listed = [row["asset_id"] for row in catalog.listing(self.out)] if packages else []
        assert listed == packages

    def require_no_process(self) -> None:
        """Driver, server, workers and their children are gone within seconds."""
        end = time.monotonic() + 10.0
        while left := [line for line in _processes() if self.name in line]:
            assert time.monotonic() < end, left
            time.sleep(0.02)


def small_batch(place: Path, texts: dict[str, str], name: str) -> SmallBatch:
    """The files of a batch below `place`, one source for each of `texts` by name."""
    (place / "in").mkdir(parents=True)
    for stem, text in texts.items():
        (place / "in" / f"{stem}.obj").write_text(text)
    (place / f"{name}.py").write_text(CELL.replace("{name}", name))
    (place / "driver.py").write_text(DRIVER.format(name=name))
    return SmallBatch(place, name)


def plain_texts(count: int) -> dict[str, str]:
    """Sources without a fault."""
    return {f"part_{number}": f"v {number} 0 0\n" for number in range(count)}


def _processes() -> list[str]:
    return subprocess.run(["ps", "-ewwo", "args"], capture_output=True, text=True, check=True).stdout.splitlines()
