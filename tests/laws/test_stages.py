"""Laws of the asset pipeline: one tuple holds order and loops, no stage knows another one, nothing is untyped."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.support.source_tree import ROOT, parsed, python_files

STAGES = ROOT / "assetkit" / "stages"
PIPELINE = ROOT / "assetkit" / "pipeline.py"
LOOPS = {"Refinement", "Retry"}
TYPED = [
    *(ROOT / "assetkit" / name for name in ("pipeline.py", "steps.py", "stage.py", "stage_log.py")),
    *sorted(STAGES.glob("*.py")),
]


def imports(path: Path) -> set[str]:
    """Modules that a file imports; for `from a import b` both `a` and `a.b`."""
    nodes = list(ast.walk(parsed(path)))
    plain = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    parts = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    return plain | {m for node in parts for m in (f"{node.module}", *(f"{node.module}.{a.name}" for a in node.names))}


def calls(path: Path) -> set[str]:
    """Plain names that a file calls."""
    nodes = [node.func for node in ast.walk(parsed(path)) if isinstance(node, ast.Call)]
    return {node.id for node in nodes if isinstance(node, ast.Name)}


@pytest.mark.parametrize("path", sorted(STAGES.glob("*.py")), ids=lambda path: path.stem)
def test_a_stage_knows_neither_the_pipeline_nor_another_stage(path: Path) -> None:
    known = {m for m in imports(path) if m.startswith(("assetkit.stages", "assetkit.pipeline", "assetkit.steps"))}
    assert known == set()


def test_only_the_pipeline_imports_stages_and_states_loops() -> None:
    """Intake comes before there is a draft; whoever needs models only calls it."""
    files = [path for path in python_files("assetkit") if path != PIPELINE]
    stages = {f"assetkit.stages.{path.stem}" for path in STAGES.glob("[a-z]*.py")} - {"assetkit.stages.intake"}
    assert {p.name for p in files if imports(p) & stages} == set()
    assert {p.name for p in files if calls(p) & LOOPS} == set()
    inside = [node for node in parsed(PIPELINE).body if isinstance(node, ast.FunctionDef)]
    assert [f.name for f in inside if any(isinstance(n, ast.Name) and n.id in LOOPS for n in ast.walk(f))] == []


@pytest.mark.parametrize("path", TYPED, ids=lambda path: path.stem)
def test_results_pass_from_stage_to_stage_with_their_types(path: Path) -> None:
    """Types that nothing checks have no place here; pyright checks these files strictly."""
    names = {node.id for node in ast.walk(parsed(path)) if isinstance(node, ast.Name)}
    assert names.isdisjoint({"Any", "cast"})
    assert "ignore" not in "".join(line.partition("#")[2] for line in path.read_text().splitlines())
