"""Worked examples of `docs/contributing/`: a page's blocks applied to a copy of the repository, its commands run there.

A page holds three kinds of blocks. Python or YAML: a whole new file, named by a comment in its first line. Diff:
changes of files, in hunks `@@` without line numbers, because the old lines of a hunk occur exactly once in the file.
Shell: commands. Under the heading "Files to touch" a numbered list names every file that changes.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"# ([\w/]+\.(?:py|yaml))\n")
LISTED = re.compile(r"^\d+\. (?:new `([\w.-]+)` in )?`([\w/.-]+)`(.*(?:\n   .*)*)", re.MULTILINE)
PROGRAMS = {"make docs": [sys.executable, "-m", "cli.docs"]}
PYTHON = ".venv/bin/python "
COPIED = ("*.py", "*.md", "*.csv", "*.json", "*.yaml", "*.toml", "*.html", "*.css")


@dataclass(frozen=True)
class Listed:
    """A file of the numbered list. Without a block: what is `by_hand`, and what is `made` by `make docs`."""

    path: str
    new: bool
    by_hand: bool
    made: bool


@dataclass(frozen=True)
class Change:
    """One hunk of a diff: `old` lines of the file `path` and what replaces them."""

    path: str
    old: str
    new: str


class NotApplicable(Exception):
    """A block of a page does not fit the repository."""


def listed(text: str) -> list[Listed]:
    """The files that the page tells to touch, in its order."""
    rows = LISTED.findall(text.partition("## Files to touch")[2].partition("\n## ")[0])
    return [
        Listed(
            f"{at.rstrip('/')}/{name}" if name else at,
            bool(name),
            "prose" in about or "no block here" in about,
            "made by `make docs`" in about,
        )
        for name, at, about in rows
    ]


def new_files(text: str) -> dict[str, str]:
    """Content of each new file by its path."""
    files: dict[str, str] = {}
    for language in ("python", "yaml"):
        for body in _blocks(text, language):
            named = NAMED.match(body)
            if named is None:
                raise NotApplicable(f"a block of {language} does not name its file in the first line")
            files[named[1]] = body[named.end() :]
    return files


def changes(text: str) -> list[Change]:
    """Hunks of all diffs, in order."""
    all_changes: list[Change] = []
    for body in _blocks(text, "diff"):
        for part in re.split(r"^--- a/", body, flags=re.MULTILINE)[1:]:
            head, *hunks = re.split(r"^@@\n", part, flags=re.MULTILINE)
            path = head.split("\n")[0]
            if head != f"{path}\n+++ b/{path}\n":
                raise NotApplicable(f"the diff of {path} does not begin with its two lines of names")
            all_changes += [_change(path, hunk) for hunk in hunks]
    return all_changes


def commands(text: str) -> list[list[str]]:
    """The commands of the page as arguments, with the Python that runs the tests."""
    lines = [line for body in _blocks(text, "sh") for line in body.splitlines()]
    return [PROGRAMS.get(line) or [sys.executable, *shlex.split(line.removeprefix(PYTHON))] for line in lines]


def copy_repository(target: Path) -> None:
    """Tracked kinds of files of the packages, tests and documents, to be changed there."""
    shutil.copytree(ROOT, target, ignore=_left_out)


def apply(text: str, root: Path) -> None:
    """Write the new files and make the changes of a page below `root`. Raises NotApplicable."""
    for path, content in new_files(text).items():
        if (root / path).exists():
            raise NotApplicable(f"{path} exists already")
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content)
    for change in changes(text):
        file = root / change.path
        before = file.read_text() if file.is_file() else ""
        if before.count(change.old) != 1:
            raise NotApplicable(f"{change.path} holds {before.count(change.old)} times:\n{change.old}")
        file.write_text(before.replace(change.old, change.new))


def restore(root: Path, original: dict[str, bytes]) -> None:
    """Make the text files below `root` those of `original`, a result of `contents`."""
    now = contents(root)
    for path in now.keys() - original.keys():
        (root / path).unlink()
    for path, content in original.items():
        if now.get(path) != content:
            (root / path).write_bytes(content)


def run(command: list[str], root: Path) -> subprocess.CompletedProcess[str]:
    """A command in a copy of the repository; its own packages go before the installed ones."""
    environment = {**os.environ, "PYTHONPATH": str(root)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # several commands run in one copy, compiled once
    if command[1:3] == ["-m", "pytest"]:
        command = [*command, "-p", "no:cacheprovider", "-p", "no:xdist"]
    return subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)


def contents(root: Path) -> dict[str, bytes]:
    """Bytes of every text file by its path below `root`."""
    return {p.relative_to(root).as_posix(): p.read_bytes() for kind in COPIED for p in root.rglob(kind)}


def _blocks(text: str, language: str) -> list[str]:
    return [body for name, body in FENCE.findall(text) if name == language]


def _change(path: str, hunk: str) -> Change:
    lines = hunk.splitlines(keepends=True)
    if any(line[0] not in " +-" for line in lines):
        raise NotApplicable(f"a line of the diff of {path} begins with neither blank, + nor -")
    return Change(
        path,
        "".join(line[1:] for line in lines if line[0] in " -"),
        "".join(line[1:] for line in lines if line[0] in " +"),
    )


def _left_out(folder: str, names: list[str]) -> list[str]:
    """What a copy does not need: hidden and made folders, pictures, data of the root."""
    at_root = Path(folder) == ROOT
    # A folder of package metadata without its PKG-INFO would hide the installed version.
    taken = [n for n in names if not n.startswith(".") and n not in ("__pycache__", "images")]
    taken = [n for n in taken if not n.endswith(".egg-info")]
    taken = [n for n in taken if Path(folder, n).is_dir() or any(Path(n).match(kind) for kind in COPIED)]
    if at_root:
        taken = [
            n for n in taken if n in ("docs", "tests", "tools") or (ROOT / n / "__init__.py").is_file() or "." in n
        ]
    return [n for n in names if n not in taken]
