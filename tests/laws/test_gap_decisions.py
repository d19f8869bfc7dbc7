"""Laws of the sim gap's search: decisions carry reasons, problems answer for themselves and change no other."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from schemas.sim_gap.decisions import Reason
from tests.support.source_tree import ROOT, parsed, python_files

INFERENCE, KINDS = ROOT / "simgap" / "inference", ROOT / "simgap" / "kinds"
SEARCHES = (INFERENCE, ROOT / "simgap" / "whole_trials")
REFERENCE = ROOT / "docs" / "reference" / "gap-output.md"
# Facts that the library or a declaration states about two candidates; no measurement decides them.
LOOKUPS = {"are_confusable", "is_twin"}
QUESTIONS_OF_KIND = {"isinstance", "issubclass", "hasattr", "runtime_checkable"}


def test_no_function_of_the_inference_answers_with_a_bare_boolean() -> None:
    """A test of a candidate returns a `Decision`: whether, why, and by which values."""
    bare = {name for path in INFERENCE.glob("*.py") for name in boolean_functions(parsed(path))}
    assert bare == LOOKUPS


def test_every_reason_is_given_by_a_search() -> None:
    """The list is closed in both directions: none is written that is not listed, none is listed for nothing."""
    used = {
        node.attr
        for folder in SEARCHES
        for path in folder.glob("*.py")
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "Reason"
    }
    assert used == {reason.name for reason in Reason}


def test_the_reference_lists_every_reason() -> None:
    """In the order of the class, one row each."""
    rows = re.findall(r"^\| `([^`]+)` \| [^|]+ \| [^|]+ \|$", REFERENCE.read_text(), re.MULTILINE)
    assert [row for row in rows if row in set(Reason)] == [reason.value for reason in Reason]


def test_no_search_asks_of_which_class_a_value_is() -> None:
    """What a problem can do is answered by its protocol: `whole_trials`, `bootstrap_sample` and the like."""
    paths = [
        *(path for folder in SEARCHES for path in folder.glob("*.py")),
        ROOT / "simgap" / "problem.py",
        ROOT / "simgap" / "find_gap.py",
    ]
    assert {path.name: line for path in paths for line in questions_of_kind(parsed(path))} == {}


def test_no_caller_asks_of_which_kind_a_problem_is() -> None:
    """Not even the report and the commands, which draw other pictures for other kinds."""
    paths = [path for path in python_files("simgap", "cli") if path.parent != INFERENCE]
    asked = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in paths
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "isinstance"
        and ast.unparse(node.args[1]).endswith("Problem")
    ]
    assert asked == []


def test_a_problem_changes_no_other_object() -> None:
    """A sibling is made by its constructor; attributes are set on `self` alone, and nothing is copied half."""
    problems = [path for path in python_files("simgap") if KINDS in path.parents and path.name == "problem.py"]
    assert len(problems) == 4
    for path in (*problems, KINDS / "mechanism" / "windowed_logs.py"):
        assert list(changes_of_others(parsed(path))) == [], path


def boolean_functions(tree: ast.Module) -> Iterator[str]:
    """Functions whose annotation returns a boolean, alone or in a tuple or an option."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.returns is not None and node.name != "__bool__":
            names = {part.id for part in ast.walk(node.returns) if isinstance(part, ast.Name)}
            if "bool" in names:
                yield node.name


def questions_of_kind(tree: ast.Module) -> Iterator[int]:
    """Lines that use a name of `QUESTIONS_OF_KIND`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in QUESTIONS_OF_KIND:
            yield node.lineno


def changes_of_others(tree: ast.Module) -> Iterator[int]:
    """Lines that set an attribute of something else than `self`, or copy `self`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del):
            if not (isinstance(node.value, ast.Name) and node.value.id == "self"):
                yield node.lineno
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("copy", "copy.copy", "setattr"):
            yield node.lineno


def test_the_laws_see_what_they_forbid() -> None:
    """The code that was there before them."""
    mutates = ast.parse("other = copy(self)\nother._around, other._starts = model, {}\nself._x = best._settled\n")
    assert sorted(changes_of_others(mutates)) == [1, 2, 2]
    asks = ast.parse("if direct is None and isinstance(state.problem, LongHorizonProblem):\n    pass\n")
    assert list(questions_of_kind(asks)) == [1]
    bare = ast.parse(
        "def agrees(x) -> bool | None: ...\ndef fits(x) -> tuple[Fit, bool]: ...\ndef good(x) -> Decision: ..."
    )
    assert list(boolean_functions(bare)) == ["agrees", "fits"]
