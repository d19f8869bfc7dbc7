"""Updates a syntax tree without parsing when only the digits of decimal numbers changed, the most frequent edit."""

from __future__ import annotations

import re

from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping

# A decimal number that every YAML 1.2 reader converts to the same float.
_DECIMAL = re.compile(r"(?<![\w.+\-])-?(?:0|[1-9][0-9]*)\.[0-9]+(?![\w.+\-])")
_MARK = "\0"  # no text holds it


def masked(text: str) -> str:
    """The text with a mark in place of each character of its decimal numbers."""
    return _DECIMAL.sub(lambda match: _MARK * len(match[0]), text)


def renumbered(tree: Tree, first_line: int, old: str, new: str) -> Tree | None:
    """The tree of `new`, given that of `old`, which begins on line `first_line` (from 0) and has the same masked text.

    None where a changed number is not a scalar value: part of a string, a key or a comment.
    """
    changed: dict[tuple[int, int], tuple[str, str]] = {}
    for match in _DECIMAL.finditer(old):
        begin, end = match.span()
        if old[begin:end] != new[begin:end]:
            line, column = old.count("\n", 0, begin), begin - old.rfind("\n", 0, begin)
            changed[first_line + line + 1, column] = old[begin:end], new[begin:end]
    edited = _replaced(tree, changed)
    return None if changed else edited


def _replaced(tree: Tree, changed: dict[tuple[int, int], tuple[str, str]]) -> Tree:
    # Removes the entries that it has applied from `changed`.
    if isinstance(tree, Scalar):
        at = (tree.at.line or 0, tree.at.column or 0)
        if at not in changed or changed[at][0] != tree.text or not isinstance(tree.value, float):
            return tree
        text = changed.pop(at)[1]
        return Scalar(float(text), text, tree.at)
    if isinstance(tree, TreeList):
        return TreeList(tuple(_replaced(item, changed) for item in tree.items), tree.at)
    return TreeMapping(
        {key: TreeEntry(item.at, _replaced(item.value, changed)) for key, item in tree.items.items()}, tree.at
    )
