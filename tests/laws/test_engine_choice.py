"""Only `cli` chooses engines: no string of another package names a module of `sim.bullet` or of `cli`.

The import contracts see import statements. An engine given by name is imported dynamically, and a package could hold
such a name itself; this law reads the string literals, without docstrings, which may give the name as an example.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from cli.engines import REPLAY_CANDIDATES, REPLAY_ENGINE, SIMULATOR
from sim.named_engine import load_engine
from tests.support.source_tree import PACKAGES, ROOT, parsed, python_files

ENGINES = ROOT / "sim" / "bullet"
BELOW_CLI = tuple(package for package in PACKAGES if package != "cli")
CHOICE = re.compile(r"\bsim\.bullet\b|\bsim[./]bullet/|^cli(\.\w+)+(:\w+)?$")


def choices(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and text of each string literal that names an engine or a module of `cli`; docstrings are none."""
    bodies = [body for node in ast.walk(tree) if isinstance(body := getattr(node, "body", None), list)]
    plain = {id(node.value) for body in bodies for node in body if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        text = joined(node)
        if isinstance(node, ast.expr) and text is not None and id(node) not in plain and CHOICE.search(text):
            yield node.lineno, text


def joined(node: ast.AST) -> str | None:
    """The text of a string literal, or of literals joined by `+`; None for any other node."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = joined(node.left), joined(node.right)
        return None if left is None or right is None else left + right
    return None


@pytest.mark.parametrize("package", BELOW_CLI)
def test_no_package_below_cli_names_an_engine(package: str) -> None:
    files = [path for path in python_files(package) if not path.is_relative_to(ENGINES)]
    assert files
    assert [f"{where(path)}:{line} {text!r}" for path in files for line, text in choices(parsed(path))] == []


@pytest.mark.parametrize("name", [SIMULATOR, REPLAY_ENGINE, REPLAY_CANDIDATES])
def test_names_that_cli_passes_are_choices_and_exist(name: str) -> None:
    assert list(choices(ast.parse(f"engine = {name!r}"))) == [(1, name)]
    assert callable(load_engine(name))


@pytest.mark.parametrize(
    "statement",
    [
        'import_module("sim.bullet.simulator")',
        'import_module("sim" + ".bullet")',
        'run_module(f"sim.bullet.{name}")',
        'WORKER = "cli.replay.cell"',
        'def f(engine="sim.bullet.simulator:BulletSimulator"): ...',
    ],
)
def test_choices_are_found(statement: str) -> None:
    assert len(list(choices(ast.parse(statement)))) == 1


@pytest.mark.parametrize(
    "statement",
    [
        '"""As `sim.bullet.simulator` does."""',
        'def f():\n    """PyBullet is `sim.bullet.simulator:BulletSimulator`."""',
        'X = 1\n"""Documents X: see `sim.bullet`."""',
        'TEXT = "the client of the server"',
        'WORKER = "sim.named_engine"',
    ],
)
def test_documentation_and_other_modules_are_no_choices(statement: str) -> None:
    assert list(choices(ast.parse(statement))) == []


def where(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()
