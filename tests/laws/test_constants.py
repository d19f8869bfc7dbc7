"""Module-level numeric constants: within one package, one name stands for one value."""

from __future__ import annotations

import ast
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

REPO = Path(__file__).parents[2]
PACKAGES = (
    *("assetkit", "cli", "dsl", "formats", "gate", "geom", "jobs", "render", "replay", "runtime_plan"),
    *("scene_check", "scenec", "schemas", "sim", "simgap", "source", "task", "usdio"),
)
# (package, name) that may have several values, and the reason why these are different notions. Rename before adding.
DIFFERENT_NOTIONS: dict[tuple[str, str], str] = {}
_KNOWN = {"np": np, "math": math, "float": float, "int": int, "__builtins__": {}}


def constants(tree: ast.Module) -> Iterator[tuple[str, int, object]]:
    """Name without leading underscores, line and value of each numeric constant that a module assigns."""
    known: dict[str, Any] = dict(_KNOWN)
    for node in tree.body:
        if isinstance(node, ast.Assign):
            targets, value = node.targets, node.value
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            targets, value = [node.target], node.value
        else:
            continue
        for target in targets:
            if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                pairs = list(zip(target.elts, value.elts, strict=True))
            else:
                pairs = [(target, value)]
            for name, expression in pairs:
                if isinstance(name, ast.Name) and name.id.isupper():
                    number = numbers(expression, known)
                    if number is not None:
                        known[name.id] = number
                        yield name.id.lstrip("_"), node.lineno, comparable(number)


def numbers(expression: ast.expr, known: dict[str, Any]) -> Any:
    """The value of an expression of numbers; None for anything else."""
    try:
        value = eval(compile(ast.Expression(expression), "", "eval"), dict(known))
        array = np.asarray(value)
    except (NameError, AttributeError, TypeError, ValueError, SyntaxError, KeyError):
        return None
    return value if array.dtype.kind in "iuf" and not isinstance(value, str | bytes | dict) else None


def comparable(value: Any) -> object:
    """A number or the shape and numbers of an array, as something to put into a set."""
    array = np.asarray(value, dtype=np.float64)
    return float(array) if array.ndim == 0 else (array.shape, tuple(array.ravel().tolist()))


def clashes(sources: dict[str, str]) -> dict[str, list[str]]:
    """Names with more than one value in modules (path -> text), and where each value is."""
    values: dict[str, set[object]] = defaultdict(set)
    places: dict[str, list[str]] = defaultdict(list)
    for path, text in sources.items():
        for name, line, value in constants(ast.parse(text)):
            values[name].add(value)
            places[name].append(f"{path}:{line} {value}")
    return {name: places[name] for name, of_name in values.items() if len(of_name) > 1}


@pytest.mark.parametrize("package", PACKAGES)
def test_one_name_has_one_value(package: str):
    sources = {str(p.relative_to(REPO)): p.read_text() for p in sorted((REPO / package).rglob("*.py"))}
    found = clashes(sources)
    allowed = {name for of_package, name in DIFFERENT_NOTIONS if of_package == package}
    assert {name: places for name, places in found.items() if name not in allowed} == {}
    assert allowed <= found.keys(), "no longer needed in the table"


def test_clashes_are_found():
    sources = {
        "a.py": "import numpy as np\n_LIMIT_M, OTHER = 0.5, 3\nNEAR_RAD = np.radians(10.0)\nTEXT = 'x'\n",
        "b.py": "LIMIT_M: float = 2.0 * 0.3\nOTHER = 3.0\nNEAR_RAD = 10.0 * np.pi / 180.0\nTEXT = 'y'\n",
    }
    assert list(clashes(sources)) == ["LIMIT_M"]
