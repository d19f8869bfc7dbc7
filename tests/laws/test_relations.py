"""Each relation of the scene language has one home: no code outside the files of the relations knows a word.

The table of words, the compiler's files, the judge's predicates and the small programs name the same relations.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from scene_check.relations import PREDICATES
from scenec.relations.table import RELATIONS, WRITTEN_RELATIONS
from schemas.scene.relations import RELATION_KINDS, RELATION_WORDS, Relation

ROOT = Path(__file__).parents[2]
HOMES = ("schemas/scene/relations.py", "scene_check/relations.py", "scenec/relations/")
FOLDERS = ("schemas/scene", "scene_check", "scenec", "runtime_plan")
NOT_WORDS = frozenset({"protocol", "table", "__init__"})
WORDS = frozenset({row.word for row in RELATION_WORDS} | set(RELATION_KINDS))


def words_in(source: str) -> list[tuple[int, str]]:
    """Line and word of each string of a source that is a relation's word, documentation aside."""
    tree = ast.parse(source)
    texts = [n.value for n in ast.walk(tree) if isinstance(n, ast.Expr)]
    constants = [n for n in ast.walk(tree) if isinstance(n, ast.Constant) and n not in texts]
    return [(n.lineno, n.value) for n in constants if isinstance(n.value, str) and n.value in WORDS]


def test_no_code_outside_the_files_of_relations_knows_a_word() -> None:
    files = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
    names = {path: path.relative_to(ROOT).as_posix() for path in files}
    outside = [path for path in files if not names[path].startswith(HOMES)]
    assert len(outside) > 100
    assert {names[path]: words for path in outside if (words := words_in(path.read_text()))} == {}


def test_a_word_in_the_code_is_seen() -> None:
    assert words_in('"""near"""\nif rule.kind == "near" or kind in ("above", "x"):\n    "below"\n') == [
        (2, "near"),
        (2, "above"),
    ]


def test_every_kind_has_a_file_and_every_file_is_a_kind() -> None:
    files = {path.stem for path in (ROOT / "scenec" / "relations").glob("*.py")} - NOT_WORDS
    assert files == set(RELATIONS)
    assert tuple(WRITTEN_RELATIONS) == RELATION_KINDS
    assert all(RELATIONS[kind].kind == kind for kind in RELATIONS)


def test_the_judge_has_a_predicate_of_every_kind() -> None:
    assert set(PREDICATES) == set(RELATION_KINDS)


@pytest.mark.parametrize("row", RELATION_WORDS, ids=lambda row: row.word)
def test_every_word_has_a_row_of_the_page_and_a_small_program(row) -> None:
    assert row.word in {word for word, _, _ in WRITTEN_RELATIONS[row.kind].page}
    programs = (ROOT / "tests" / "data" / "scenes").glob("*.yaml")
    assert any(f"{{{row.word}:" in path.read_text() for path in programs)
    assert row.keys | {row.word} <= set(Relation.model_fields)
    assert {*row.needs, *(key for key, _ in row.only_with)} <= row.keys
    assert {form for key in row.radians for form in (key, f"{key}_deg")} <= row.keys
