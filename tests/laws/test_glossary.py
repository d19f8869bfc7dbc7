"""The glossary is a law: no module, class, function, method, field or parameter bears a name that it forbids."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tests.support.source_tree import PACKAGES, ROOT, parsed, python_files

GLOSSARY = ROOT / "docs" / "glossary.md"
_ROW = re.compile(r"^\| \*\*(?P<term>[^|*]+)\*\*[^|]* \| (?P<definition>[^|]+) \| (?P<forbidden>[^|]*) \|$")


def rows() -> list[tuple[str, str, tuple[str, ...]]]:
    """(term, definition, names it must not bear) of each row of the table."""
    matches = [_ROW.match(line) for line in GLOSSARY.read_text().splitlines()]
    return [(m["term"], m["definition"], tuple(re.findall(r"`([^`]+)`", m["forbidden"]))) for m in matches if m]


def forbidden() -> dict[str, str]:
    """Each forbidden name with the term to use instead."""
    return {name: term for term, _, names in rows() for name in names}


def definitions(path: Path) -> Iterator[tuple[int, str]]:
    """Line and name of all that a file defines: itself, classes, functions, fields, parameters."""
    yield 1, path.stem
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.ClassDef):
            yield node.lineno, node.name
            fields = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
            yield from ((field.lineno, field.id) for field in fields if isinstance(field, ast.Name))
        elif isinstance(node, ast.FunctionDef):
            yield node.lineno, node.name
            arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            yield from ((argument.lineno, argument.arg) for argument in arguments)


def test_no_definition_bears_a_forbidden_name() -> None:
    """A leading underscore does not make a private word a standard term."""
    names = forbidden()
    bad = [
        f"{path.relative_to(ROOT)}:{line}: {name!r} is called {names[name.lstrip('_')]!r}"
        for path in python_files(*PACKAGES, "tests", "benchmarks")
        for line, name in definitions(path)
        if name.lstrip("_") in names
    ]
    assert bad == []


def test_the_glossary_is_a_table_in_alphabetical_order() -> None:
    """Each term has a definition; no name is forbidden twice or is itself a term."""
    terms = [term for term, _, _ in rows()]
    assert len(terms) >= 60
    assert terms == sorted(terms, key=str.casefold)
    names = [name for _, _, row in rows() for name in row]
    assert len(names) == len(set(names))
    assert len(names) >= 80
    assert not set(names) & set(terms)
