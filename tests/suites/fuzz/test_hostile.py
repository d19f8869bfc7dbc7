"""Each hostile input ends in its diagnostic, soon, and opens no file outside its folder."""

from __future__ import annotations

import resource
import time
from pathlib import Path

import pytest

from schemas.codes import CODES
from tests.suites.fuzz import hostile
from tests.suites.fuzz.outside import Watch, make_outside
from tests.suites.fuzz.readers.by_format import READERS

CASES = {
    f"{kind}: {name}": case
    for kind in ("REFERENCES", "BOMBS", "CYCLES", "NUMBERS", "KINDS")
    for name, case in getattr(hostile, kind).items()
}
MOST_CPU_S, MOST_GROWTH_MB = 10.0, 1500.0


@pytest.mark.parametrize("name", CASES)
def test_a_hostile_input_ends_in_its_code(name: str, tmp_path: Path):
    case = CASES[name]
    folder, file = case.write(tmp_path)
    started, before_mb = time.process_time(), peak_mb()
    with Watch(make_outside(tmp_path / "outside")) as watch:
        note = READERS[case.format](folder, file)
        assert watch.events() == []
    assert note.trace == ""
    assert note.broken == []
    errors = [code for code in note.codes if CODES[code].severity == "error"]
    assert set(case.codes) & set(note.codes) if case.codes else errors, note.codes
    assert "asset/internal-error" not in note.codes
    assert time.process_time() - started < MOST_CPU_S
    assert peak_mb() - before_mb < MOST_GROWTH_MB
    assert sorted(p.name for p in tmp_path.iterdir()) == ["case", "outside"]


def test_the_watch_reports_who_opens_a_file(tmp_path: Path):
    """The judge itself: reading, writing and listing are seen; looking at attributes is not reading."""
    outside = make_outside(tmp_path / "outside")
    with Watch(outside) as watch:
        (outside / "secret.obj").stat()
        assert watch.events() == []
        (outside / "secret.obj").read_bytes()
        assert watch.events() == ["opened secret.obj"]
        (outside / "new").write_text("x")
        assert "created new" in watch.events()
        list(outside.iterdir())
        assert watch.events() == ["opened (the folder)"]


def peak_mb() -> float:
    """The largest resident memory of this process so far, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
