"""The pages of docs/contributing are true: their worked examples run, and their lists of files are whole.

Each page with an example is applied to a copy of the repository; its own tests and commands run there. So a page that
the code has left behind fails here, with the block that no longer fits.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.support.worked_pages import (
    ROOT,
    NotApplicable,
    apply,
    changes,
    commands,
    contents,
    copy_repository,
    listed,
    new_files,
    run,
)

PAGES = ROOT / "docs" / "contributing"
WORKED = ("file-format", "gate-rule", "effect", "episode-format")


def page(name: str) -> str:
    return (PAGES / f"{name}.md").read_text()


@pytest.mark.parametrize("name", WORKED)
def test_the_worked_example_runs(name: str, tmp_path: Path) -> None:
    text, copy = page(name), tmp_path / "mana"
    copy_repository(copy)
    apply(text, copy)
    before = contents(copy)
    style = [[sys.executable, "-m", "ruff", *way, *new_files(text)] for way in (["check"], ["format", "--check"])]
    assert commands(text)
    for command in [*style, *commands(text)]:
        ended = run(command, copy)
        assert ended.returncode == 0, f"{' '.join(command[1:])}\n{ended.stdout[-4000:]}{ended.stderr[-4000:]}"
    after = contents(copy)
    made = {path for path in before.keys() | after.keys() if before.get(path) != after.get(path)}
    assert made == {file.path for file in listed(text) if file.made}
