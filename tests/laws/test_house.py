"""Laws of the source tree: how many files lie side by side, what a name may be, what a docstring must say.

The rules are those of CONTRIBUTING.md; each test here names one and lists what breaks it.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.source_tree import PACKAGES, ROOT, parsed, python_files

MOST_FILES = 25
# Folders that may hold more files side by side, each with its reason; at most three.
LARGE_FOLDERS: dict[str, str] = {}

VAGUE = frozenset({"found", "kept", "said", "told", "own", "made", "wanted"})
VAGUE_SPAN_LINES = 8  # a vague local is fine where its last use is in sight of its binding

# Verbs of speech and posture that hide what data is; a docstring names the value, the file or the test instead.
ANTHROPOMORPHIC = re.compile(r"\b(told|tells?|asked|asks|heard|hears|speaks?|spoken)\b", re.IGNORECASE)
SHORTEST_MODULE_DOCSTRING = 30  # characters; `"""Helpers."""` says nothing


def test_folders_hold_at_most_25_python_files() -> None:
    """A listing shows `__init__.py` too, so it counts."""
    counts = Counter(path.parent.relative_to(ROOT).as_posix() for path in python_files())
    assert len(LARGE_FOLDERS) <= 3
    assert {folder: n for folder, n in counts.items() if n > MOST_FILES and folder not in LARGE_FOLDERS} == {}


def test_every_folder_of_python_files_is_a_package_with_a_docstring() -> None:
    """A namespace package would hide a forgotten file from the import contracts."""
    folders = {path.parent for path in python_files(*PACKAGES, "tests", "benchmarks")}
    assert [f for f in sorted(folders) if not (f / "__init__.py").is_file()] == []
    assert [f for f in sorted(folders) if not ast.get_docstring(parsed(f / "__init__.py"))] == []


def test_stage_folder_holds_the_stages_and_nothing_else() -> None:
    """Each file of `assetkit/stages` defines one class with `name`, `version`, `result` and `run`."""
    for path in (ROOT / "assetkit" / "stages").glob("*.py"):
        if path.name == "__init__.py":
            continue
        stages = [node for node in parsed(path).body if isinstance(node, ast.ClassDef) and _is_stage(node)]
        assert len(stages) == 1, f"{path.name} holds {len(stages)} stages"


def _is_stage(node: ast.ClassDef) -> bool:
    methods = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    fields = {
        t.id for item in node.body if isinstance(item, ast.Assign) for t in item.targets if isinstance(t, ast.Name)
    }
    return "run" in methods and {"name", "version", "result"} <= fields


@pytest.mark.parametrize("package", [*PACKAGES, "tests", "benchmarks"])
def test_locals_that_carry_data_have_names_of_what_they_hold(package: str) -> None:
    """None of the vague words is returned, or read more than eight lines after it is bound."""
    assert [line for path in python_files(package) for line in vague_bindings(path)] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_public_class_names_are_unique_within_a_package(package: str) -> None:
    """One noun, one class: two of one name force every reader to look at the import."""
    homes: dict[str, list[str]] = {}
    for path in python_files(package):
        for node in parsed(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, []).append(path.relative_to(ROOT).as_posix())
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_name_values_rather_than_speech(package: str) -> None:
    """Data is not told, asked, heard or spoken of; a module's docstring is a sentence."""
    bad = []
    for path in python_files(package):
        tree = parsed(path)
        module = ast.get_docstring(tree) or ""
        if len(module) < SHORTEST_MODULE_DOCSTRING:
            bad.append(f"{path.relative_to(ROOT)}: module docstring {module!r}")
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                match = ANTHROPOMORPHIC.search(ast.get_docstring(node) or "")
                if match:
                    line = getattr(node, "lineno", 1)
                    bad.append(f"{path.relative_to(ROOT)}:{line}: {match.group()!r} in a docstring")
    assert bad == []


def vague_bindings(path: Path) -> Iterator[str]:
    """`file:line function name` of each binding of a vague word that is returned or read far below."""
    for function in ast.walk(parsed(path)):
        if isinstance(function, ast.FunctionDef):
            yield from (f"{path.relative_to(ROOT)}:{line} {function.name} {name}" for line, name in _far(function))


def _far(function: ast.FunctionDef) -> Iterator[tuple[int, str]]:
    arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    bound = {(argument.lineno, argument.arg) for argument in arguments if argument.arg in VAGUE}
    names = [node for node in ast.walk(function) if isinstance(node, ast.Name) and node.id in VAGUE]
    bound |= {(node.lineno, node.id) for node in names if isinstance(node.ctx, ast.Store)}
    returns = [node.value for node in ast.walk(function) if isinstance(node, ast.Return) and node.value is not None]
    inside = [inner for value in returns for inner in ast.walk(value) if isinstance(inner, ast.Name)]
    for line, name in sorted(bound):
        end = min((other for other, same in bound if same == name and other > line), default=10**9)
        read = [node.lineno for node in names if node.id == name and isinstance(node.ctx, ast.Load)]
        is_returned = any(inner.id == name and line <= inner.lineno < end for inner in inside)
        if is_returned or any(line + VAGUE_SPAN_LINES < at < end for at in read):
            yield line, name


def test_the_law_on_vague_locals_sees_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Returned, or read nine lines below, is a finding; read in sight is none."""
    monkeypatch.setattr("tests.laws.test_house.ROOT", tmp_path)
    returned, far, near = (tmp_path / f"{name}.py" for name in ("returned", "far", "near"))
    returned.write_text("def f(x):\n    found = x\n    return found\n")
    assert len(list(vague_bindings(returned))) == 1
    far.write_text("def f(x):\n    found = x\n" + "    x += 1\n" * 8 + "    x += found\n")
    assert len(list(vague_bindings(far))) == 1
    near.write_text("def f(x):\n    found = x\n    x += found\n    return x\n")
    assert list(vague_bindings(near)) == []
