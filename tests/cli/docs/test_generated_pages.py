"""Generated pages of the documentation are those that the code makes now, all of them, and no stale one lies beside."""

from pathlib import Path

import pytest

from cli.docs.__main__ import DIAGNOSTICS, generated_pages, write

DOCS = Path(__file__).parents[3] / "docs"
PAGES = generated_pages()


@pytest.mark.parametrize("path", PAGES, ids=str)
def test_the_page_is_up_to_date(path: Path) -> None:
    assert (DOCS / path).read_text() == PAGES[path], "run `make docs`"


def test_no_page_of_a_code_that_is_gone() -> None:
    assert {p.relative_to(DOCS) for p in (DOCS / DIAGNOSTICS).glob("*.md")} == {
        p for p in PAGES if p.parent == DIAGNOSTICS
    }


def test_writing_replaces_all_and_removes_what_is_stale(tmp_path: Path) -> None:
    stale = tmp_path / DIAGNOSTICS / "asset-gone.md"
    stale.parent.mkdir()
    stale.write_text("old")
    write(tmp_path)
    written = {p.relative_to(tmp_path): p.read_text() for p in tmp_path.rglob("*.md")}
    assert written == PAGES
