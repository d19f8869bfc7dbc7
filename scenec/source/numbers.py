"""The commonest edit: a text in which other decimal numbers stand, as long as before, needs no parser."""

from __future__ import annotations

import re

from scenec.source.tree import Block, Item, Row, Scalar, Tree

# A decimal number by itself, of which every reader of YAML 1.2 makes the same float.
_DECIMAL = re.compile(r"(?<![\w.+\-])-?(?:0|[1-9][0-9]*)\.[0-9]+(?![\w.+\-])")
_MARK = "\0"  # no text holds it


def masked(text: str) -> str:
    """The text with a mark in place of each character of its decimal numbers."""
    return _DECIMAL.sub(lambda found: _MARK * len(found[0]), text)


def renumbered(tree: Tree, first_line: int, old: str, new: str) -> Tree | None:
    """The tree of `new`, given that of `old`, which begins on line `first_line` (from 0) and has the same masked text.

    None where a number that changed is no value by itself: part of a text, a key, a comment.
    """
    changed: dict[tuple[int, int], tuple[str, str]] = {}
    for found in _DECIMAL.finditer(old):
        begin, end = found.span()
        if old[begin:end] != new[begin:end]:
            line, column = old.count("\n", 0, begin), begin - old.rfind("\n", 0, begin)
            changed[first_line + line + 1, column] = old[begin:end], new[begin:end]
    made = _replaced(tree, changed)
    return None if changed else made


def _replaced(tree: Tree, changed: dict[tuple[int, int], tuple[str, str]]) -> Tree:
    # Takes what it has replaced out of `changed`.
    if isinstance(tree, Scalar):
        at = (tree.at.line or 0, tree.at.column or 0)
        if at not in changed or changed[at][0] != tree.text or not isinstance(tree.value, float):
            return tree
        text = changed.pop(at)[1]
        return Scalar(float(text), text, tree.at)
    if isinstance(tree, Row):
        return Row(tuple(_replaced(item, changed) for item in tree.items), tree.at)
    return Block({key: Item(item.at, _replaced(item.value, changed)) for key, item in tree.items.items()}, tree.at)
