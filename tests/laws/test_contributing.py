"""The pages of docs/contributing are true: paths exist, worked examples run, lists of files are whole.

A page with an example is applied to a copy of the repository, where its own tests and commands run. So a page that the
code has left behind fails here, with the block that no longer fits.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.codes import CODES
from tests.support.worked_pages import (
    FENCE,
    ROOT,
    NotApplicable,
    apply,
    changes,
    commands,
    contents,
    copy_repository,
    listed,
    new_files,
    restore,
    run,
)

FOLDER = ROOT / "docs" / "contributing"
PAGES = ("file-format", "gate-rule", "effect", "episode-format", "relation", "generator", "suite")
# What a newcomer opens or writes for one more of a kind: reader, row and test; and so on.
MOST_FILES = {"file-format": 3, "gate-rule": 3, "relation": 4, "effect": 3, "generator": 3, "suite": 5}

PATH = re.compile(r"`((?:[\w-]+/)+[\w.-]*)`")
MODULE = re.compile(r"`([a-z]\w*(?:\.\w+)+)`")
SAMPLE = """## Files to touch, in order

1. new `new.py` in `folder/`: a file.
2. `old.py`: a change.
3. `page.md`, here: made by `make docs`.

## Example

```python
# folder/new.py
NEW = 1
```

```diff
--- a/old.py
+++ b/old.py
@@
 first
-second
+third
```

```sh
make docs
.venv/bin/python -m pytest tests -k "a or b"
```
"""


def page(name: str) -> str:
    return (FOLDER / f"{name}.md").read_text()


def style_and_laws(new: list[str]) -> list[list[str]]:
    """Commands that hold new files to the style and the laws of the package that they belong to."""
    python = [path for path in new if path.endswith(".py")]
    ruff = [[sys.executable, "-m", "ruff", *way, *python] for way in (["check"], ["format", "--check"])]
    package = python[0].partition("/")[0]
    laws = ["tests/laws/test_house.py", "tests/laws/test_constants.py"]
    return [*ruff, [sys.executable, "-m", "pytest", *laws, "-k", f"[{package}]"]]


def lost_names(text: str) -> list[str]:
    """Paths and modules in backticks below our folders that neither exist nor are new on the page itself."""
    new = [Path(path) for path in (*new_files(text), *(file.path for file in listed(text) if file.made))]
    known = {path.as_posix() for each in new for path in (each, *each.parents)}
    tops = {path.name for path in ROOT.iterdir() if path.is_dir()}
    paths = [name for name in PATH.findall(FENCE.sub("", text)) if name.partition("/")[0] in tops and name not in CODES]
    modules = [name for name in MODULE.findall(text) if (ROOT / name.partition(".")[0] / "__init__.py").is_file()]
    lost = [name for name in paths if name.rstrip("/") not in known and not (ROOT / name).exists()]
    return lost + [name for name in modules if not is_module_or_member(name)]


def is_module_or_member(name: str) -> bool:
    """Whether `a.b.c` is a module, or a name that the module `a.b` binds."""
    at = ROOT.joinpath(*name.split("."))
    if at.with_suffix(".py").is_file() or (at / "__init__.py").is_file():
        return True
    source = at.parent.with_suffix(".py") if at.parent.with_suffix(".py").is_file() else at.parent / "__init__.py"
    return source.is_file() and re.search(rf"\b{at.name}\b", source.read_text()) is not None


@pytest.mark.parametrize("name", PAGES)
def test_every_path_and_module_on_the_page_exists(name: str) -> None:
    assert lost_names(page(name)) == []


@pytest.mark.parametrize("name", PAGES)
def test_the_page_says_how_to_test_and_what_is_reviewed(name: str) -> None:
    assert [h for h in ("## Files to touch", "## Test", "## What reviewers look for") if h not in page(name)] == []


@pytest.mark.parametrize(("name", "most"), MOST_FILES.items())
def test_an_extension_touches_few_files_by_hand(name: str, most: int) -> None:
    """Without pages that `make docs` writes, and without the line in the change log that every change gets."""
    touched = {file.path for file in listed(page(name)) if not file.made} - {"CHANGELOG.md"}
    assert 0 < len(touched) <= most, sorted(touched)


@pytest.mark.parametrize("name", PAGES)
def test_the_list_of_files_is_what_the_blocks_change(name: str) -> None:
    text = page(name)
    rows = listed(text)
    assert [file.path for file in rows if file.new] == sorted(new_files(text), key=[f.path for f in rows].index)
    changed = {change.path for change in changes(text)}
    assert {file.path for file in rows if not (file.new or file.by_hand or file.made)} == changed


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the repository, shared by all pages so that its modules are compiled once."""
    folder = tmp_path_factory.mktemp("copy") / "mana"
    copy_repository(folder)
    return folder


@pytest.fixture
def original(copy: Path) -> Iterator[dict[str, bytes]]:
    """The files of the copy as they are before a page is applied, and again after the test."""
    files = contents(copy)
    yield files
    restore(copy, files)


@pytest.mark.parametrize("name", PAGES)
def test_the_worked_example_runs(name: str, copy: Path, original: dict[str, bytes]) -> None:
    text = page(name)
    apply(text, copy)
    for command in [*style_and_laws(list(new_files(text))), *commands(text)]:
        ended = run(command, copy)
        assert ended.returncode == 0, f"{' '.join(command[1:])}\n{ended.stdout[-4000:]}{ended.stderr[-4000:]}"
    after = contents(copy)
    differing = {path for path in original.keys() | after.keys() if original.get(path) != after.get(path)}
    assert differing == {file.path for file in listed(text) if not file.by_hand}


def test_blocks_of_a_page_are_read_and_applied(tmp_path: Path) -> None:
    (tmp_path / "old.py").write_text("first\nsecond\n")
    apply(SAMPLE, tmp_path)
    assert {p.name: p.read_text() for p in tmp_path.rglob("*.py")} == {
        "new.py": "NEW = 1\n",
        "old.py": "first\nthird\n",
    }
    assert [(f.path, f.new, f.made) for f in listed(SAMPLE)] == [
        ("folder/new.py", True, False),
        ("old.py", False, False),
        ("page.md", False, True),
    ]
    docs, tests = commands(SAMPLE)
    assert (docs[1:], tests[1:]) == (["-m", "cli.docs"], ["-m", "pytest", "tests", "-k", "a or b"])


@pytest.mark.parametrize("before", ["first\nthird\n", "first\nsecond\nfirst\nsecond\n"])
def test_a_hunk_that_fits_nowhere_or_twice_is_refused(tmp_path: Path, before: str) -> None:
    (tmp_path / "old.py").write_text(before)
    with pytest.raises(NotApplicable):
        apply(SAMPLE, tmp_path)


def test_names_that_do_not_exist_are_found() -> None:
    lost = ["gate/no_such.py", "tests/no_such/", "gate.no_such", "gate.static_gate.NO_SUCH"]
    good = ["gate/rules/", "gate/static_gate.py", "gate.static_gate.RULES", "replay/unknown-format", "np.array"]
    assert lost_names("".join(f"`{name}` " for name in [*good, *lost])) == lost
    assert lost_names("```python\n# gate/no_such.py\nX = 1\n```\n`gate/no_such.py`") == []
