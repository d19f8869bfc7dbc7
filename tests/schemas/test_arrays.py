"""Array types have one home."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import schemas.arrays

REPO = Path(__file__).parents[2]
ALIASES = {name for name in vars(schemas.arrays) if name.endswith("Array") and name != "NDArray"}
SOURCES = [
    path
    for path in sorted(REPO.rglob("*.py"))
    if path != Path(schemas.arrays.__file__) and not any(part.startswith(".") for part in path.relative_to(REPO).parts)
]


def other_homes(text: str) -> list[str]:
    """Aliases that a module defines itself or imports from elsewhere than `schemas.arrays`."""
    homes_elsewhere: list[str] = []
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom) and node.module != "schemas.arrays":
            homes_elsewhere += [alias.name for alias in node.names if alias.name in ALIASES]
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            homes_elsewhere += [
                target.id for target in targets if isinstance(target, ast.Name) and target.id in ALIASES
            ]
    return homes_elsewhere


def test_array_types_come_from_one_module():
    assert {str(path.relative_to(REPO)): found for path in SOURCES if (found := other_homes(path.read_text()))} == {}


@pytest.mark.parametrize(
    "text", ["from schemas.model import FloatArray, Mesh\n", "BoolArray = NDArray[np.bool_]\n", "IntArray: X = 1\n"]
)
def test_another_home_is_found(text: str):
    assert len(other_homes(text)) == 1
