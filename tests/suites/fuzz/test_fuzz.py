"""Damaged copies of real files: a value or a code for each, within limits; and the fuzzer notices what is not so."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.suites.fuzz.run import WITHOUT_PEERS, Run, fuzz
from tests.suites.fuzz.seeds import ASSETS, Seed, seeds_of
from tests.suites.fuzz.test_mutations import SAMPLES
from tests.support.bad_inputs import gap
from tests.support.bad_inputs.assets import usda

SLICE, SLICE_SEED = 8, "20261126"
SUFFIX = {"usd": ".usda", "mjcf": ".xml"}


def small_seed(format_name: str, scratch: Path) -> Seed:
    """The smallest sound input of a format, made here."""
    folder = scratch / f"small_{format_name}"
    folder.mkdir()
    if format_name == "measurement":
        place = gap.SAMPLES["gap/stamp-jitter"](folder)
        return Seed(format_name, place, place / "measurement.yaml")
    if format_name not in ASSETS:
        return seeds_of(format_name, scratch, 1)[0]
    if format_name == "usd":
        return Seed(format_name, folder, usda()(folder))
    suffix = SUFFIX.get(format_name, f".{format_name}")
    (folder / f"part{suffix}").write_bytes(SAMPLES[suffix])
    return Seed(format_name, folder, folder / f"part{suffix}")


def test_a_slice_of_every_format_ends_in_values_and_codes(tmp_path: Path):
    seeds = [small_seed(name, tmp_path) for name in WITHOUT_PEERS]
    rows = list(fuzz(seeds, Run(SLICE_SEED, SLICE, tmp_path)))
    assert [row.text() for row in rows if row.failure] == []
    assert Counter(row.format for row in rows) == dict.fromkeys(WITHOUT_PEERS, SLICE)
    assert any(row.made for row in rows)
    assert any(row.codes for row in rows)


@pytest.mark.long
@pytest.mark.parametrize("format_name", WITHOUT_PEERS)
def test_more_of_every_format_ends_in_values_and_codes(format_name: str, tmp_path: Path):
    seeds = seeds_of(format_name, tmp_path, 6)
    rows = list(fuzz(seeds, Run(SLICE_SEED, 25, tmp_path)))
    assert [row.text() for row in rows if row.failure] == []
    assert len(rows) == 25 * len(seeds)


# A reader that is wrong in every way, one after another by the number of the case.
PLANTED = """
import ctypes, os, sys, time
from pathlib import Path
from tests.suites.fuzz import cell
from tests.suites.fuzz.readers.by_format import READERS
from tests.suites.fuzz.readers.note import Note
calls = [int(p) for p in Path(__file__).with_name('calls').read_text().split()]
def planted(folder, file):
    kind, opened = len(calls), Path(__file__).with_name('opened')
    if kind != 3 or opened.exists(): calls.append(0)  # what opens a file outside is read twice
    Path(__file__).with_name('calls').write_text(' '.join(map(str, calls)))
    if kind == 0: return Note(made=1)
    if kind == 1: return Note(codes=['asset/internal-error'])
    if kind == 2: return Note(trace='ValueError')
    if kind == 3:
        opened.touch()
        (folder.parent / 'outside' / 'secret.obj').read_bytes()
    if kind == 4: ctypes.string_at(8)
    if kind == 5:
        while True: pass
    if kind == 6: time.sleep(100)
    if kind == 7: raise MemoryError
    if kind == 8: os._exit(3)
    return Note(codes=['asset/parse-error'])
READERS['obj'] = planted
if __name__ == '__main__':
    cell.main(sys.argv[1], sys.argv[2])
"""
FAILURES = [
    *("", "internal error", "internal error", "broken promise", "crashed", "timeout", "timeout", "out_of_memory"),
    *("failed", ""),
]


def test_the_fuzzer_notices_every_kind_of_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a_planted_cell.py").write_text(PLANTED)
    (tmp_path / "calls").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    run = Run("0", len(FAILURES), tmp_path, tmp_path / "kept", seconds=0.5, cell="a_planted_cell")
    rows = list(fuzz([small_seed("obj", tmp_path)], run))
    assert [row.failure for row in sorted(rows, key=lambda row: row.number)] == FAILURES
    assert [row.broken for row in rows if row.broken] == [("outside: opened secret.obj",)]
    assert len(list((tmp_path / "kept").iterdir())) == sum(map(bool, FAILURES))
