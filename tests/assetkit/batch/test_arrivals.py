"""A pass takes up what has settled: never a file that is still written, never a source whose other files are."""

from __future__ import annotations

from pathlib import Path

import pytest

from assetkit.batch.arrivals import Arrivals, PassScope, files_below
from assetkit.batch.report_file import FinishedBatch, write_report_json
from assetkit.sources.discover import discover
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

SETTLE_S = 2.0


@pytest.fixture
def inbox(tmp_path: Path) -> Path:
    (tmp_path / "inbox").mkdir()
    return tmp_path / "inbox"


def looks(arrivals: Arrivals, inbox: Path, *times_s: float) -> PassScope | None:
    for now_s in times_s:
        arrivals.look(files_below([inbox], inbox.parent / "library"), now_s)
    return arrivals.next_pass(None)


def chosen(selection: PassScope, inbox: Path) -> list[str]:
    return [source.file.path.name for source in selection.split(discover([inbox]))]


def test_a_file_is_taken_up_once_it_stayed_the_same_for_the_whole_time(inbox: Path) -> None:
    arrivals, file = Arrivals(SETTLE_S), inbox / "mug.stl"
    file.write_bytes(b"one")
    assert looks(arrivals, inbox, 0.0, 1.9) is None
    file.write_bytes(b"longer")  # the copy goes on
    assert looks(arrivals, inbox, 2.0, 3.9) is None
    selection = looks(arrivals, inbox, 4.1)
    assert selection is not None
    assert chosen(selection, inbox) == ["mug.stl"]
    arrivals.taken(selection)
    assert looks(arrivals, inbox, 5.0, 99.0) is None
    file.write_bytes(b"another content")
    assert looks(arrivals, inbox, 100.0) is None
    assert looks(arrivals, inbox, 102.5) is not None


def test_a_file_that_changes_during_a_pass_is_taken_up_again(inbox: Path) -> None:
    arrivals, file = Arrivals(SETTLE_S), inbox / "mug.stl"
    file.write_bytes(b"one")
    selection = looks(arrivals, inbox, 0.0, 3.0)
    assert selection is not None
    file.write_bytes(b"written while the pass ran")
    arrivals.taken(selection)
    assert looks(arrivals, inbox, 60.0, 63.0) is not None


def test_a_source_waits_for_the_other_files_of_its_folder_and_for_no_other_source(inbox: Path) -> None:
    arrivals = Arrivals(SETTLE_S)
    (inbox / "mug").mkdir()
    (inbox / "mug" / "mug.obj").write_text("mtllib mug.mtl\n")
    (inbox / "bowl.stl").write_bytes(b"whole")
    looks(arrivals, inbox, 0.0)
    (inbox / "mug" / "mug.mtl").write_text("half")
    (inbox / "cup.stl").write_bytes(b"half")
    selection = looks(arrivals, inbox, 2.5)
    assert selection is not None
    assert chosen(selection, inbox) == ["bowl.stl"]
    arrivals.taken(selection)
    later = looks(arrivals, inbox, 5.0)
    assert later is not None
    taken_up = later.split(discover([inbox]))
    assert {source.file.path.name for source in taken_up} >= {"cup.stl", "mug.obj"}


def test_what_an_unsettled_file_held_back_is_taken_up_when_that_file_goes(inbox: Path) -> None:
    arrivals = Arrivals(SETTLE_S)
    (inbox / "mug.obj").write_text("v 0 0 0")
    looks(arrivals, inbox, 0.0)
    (inbox / "download.part").write_bytes(b"half")
    selection = looks(arrivals, inbox, 2.5)
    assert selection is not None
    assert chosen(selection, inbox) == []
    arrivals.taken(selection)
    assert looks(arrivals, inbox, 3.0) is None
    (inbox / "download.part").unlink()
    later = looks(arrivals, inbox, 3.5)
    assert later is not None
    assert chosen(later, inbox) == ["mug.obj"]


def test_sources_without_a_change_keep_their_items(inbox: Path) -> None:
    for name in ("a", "b"):
        (inbox / f"{name}.stl").write_bytes(name.encode())
    out = inbox.parent / "library"
    out.mkdir()
    first = ReportItem(source=str(inbox / "a.stl"), outcome=ItemOutcome.REJECTED, codes=("asset/parse-error",))
    gone = first.model_copy(update={"source": str(inbox / "gone.stl")})
    earlier = FinishedBatch(out, {})
    write_report_json(earlier, (item.model_dump_json().encode() for item in (first, gone)))
    part = PassScope(frozenset(), frozenset({inbox / "b.stl"}), earlier).split(discover([inbox]))
    assert (part.positions, len(part)) == ((1,), 1)
    assert list(part.earlier_items()) == [(0, first.model_copy(update={"cached": ("item",)}))]
    again = PassScope(frozenset(), frozenset({inbox / "a.stl"}), earlier).split(discover([inbox]))
    assert again.positions == (0, 1)  # b has no item yet


def test_hidden_files_links_that_lead_nowhere_and_the_library_itself_are_not_watched(inbox: Path) -> None:
    (inbox / ".mug.stl.part").write_bytes(b"half")
    (inbox / "gone.stl").symlink_to(inbox / "nowhere")
    library = inbox / "library"
    library.mkdir()
    (library / "report.json").write_text("{}")
    (inbox / "mug.stl").write_bytes(b"whole")
    assert list(files_below([inbox, inbox / "mug.stl"], library)) == [inbox / "mug.stl"]
