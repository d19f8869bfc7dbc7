"""The repository's own Python files, for tests that state laws about the source tree."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = (
    "schemas",
    "geom",
    "scene_check",
    "task",
    "source",
    "formats",
    "usdio",
    "gate",
    "sim",
    "jobs",
    "render",
    "assetkit",
    "scenec",
    "runtime_plan",
    "simgap",
    "replay",
    "dsl",
    "cli",
)
TREES = (*PACKAGES, "tests", "benchmarks", "examples", "tools")


@cache
def python_files(*tops: str) -> tuple[Path, ...]:
    """Python files below the named top-level folders (all of the repository's where none is named), sorted."""
    return tuple(path for top in tops or TREES for path in sorted((ROOT / top).rglob("*.py")))


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of one file."""
    return ast.parse(path.read_text())
