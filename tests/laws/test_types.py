"""Laws of type checking: what pyright checks, how strictly, and how many lines may be exempt from it."""

from __future__ import annotations

import re
import tomllib

from tests.support.source_tree import ROOT, TREES, python_files

STRICT = ("schemas", "geom", "task", "runtime_plan", "scene_check", "formats")
# Lines with `pyright: ignore`; lower the number when lines go, never raise it.
MOST_IGNORED_LINES = 36

IGNORED_LINE = re.compile(r"# ?pyright: ?ignore")
MYPY_IGNORE = re.compile(r"# ?type: ?ignore")
WHOLE_FILE = re.compile(r"^\s*# ?pyright: ?(basic|standard|strict|report)", re.MULTILINE)


def settings() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pyright"]


def test_every_python_file_is_checked() -> None:
    assert set(settings()["include"]) == {tree for tree in (*TREES, *STRICT) if (ROOT / tree).is_dir()}
    assert "exclude" not in settings()
    assert "ignore" not in settings()


def test_packages_that_others_build_on_are_checked_strictly() -> None:
    """More may be: a package, a folder or a file."""
    strict = settings()["strict"]
    assert {package for package in STRICT if (ROOT / package).is_dir()} <= set(strict)
    assert [path for path in strict if not (ROOT / path).exists()] == []


def test_no_rule_is_switched_off_for_a_file_or_for_the_strict_packages() -> None:
    """A library without types gets a stub under `typings/` instead (`typings/README.md`)."""
    texts = {path: path.read_text() for path in python_files()}
    assert [path.relative_to(ROOT).as_posix() for path, text in texts.items() if WHOLE_FILE.search(text)] == []
    assert {rule for rule, level in settings().items() if level in (False, "none", "information")} <= {
        "reportMissingTypeStubs",  # outside of the strict packages: the library's own code is read for its types
        "reportMissingModuleSource",  # a stub without the library, such as PyTorch's
    }


def test_exempt_lines_only_go_down() -> None:
    lines = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in python_files()
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if IGNORED_LINE.search(line)
    ]
    here = f"{__file__.removeprefix(f'{ROOT}/')}:"
    assert len([line for line in lines if not line.startswith(here)]) <= MOST_IGNORED_LINES, lines


def test_lines_are_exempt_by_rule_and_not_from_all_tools() -> None:
    """`type: ignore` silences everything on a line."""
    others = [path for path in python_files() if path.name != "test_types.py"]
    assert [path.name for path in others if MYPY_IGNORE.search(path.read_text())] == []
