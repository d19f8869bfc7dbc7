"""A tree that begins farther down in its text: lines are added where somebody looks, so that moving costs nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

from scenec.source.tree import Block, Item, Row, Scalar, Tree
from schemas.diagnostics import Location


def moved(tree: Tree, lines: int) -> Tree:
    """The tree of the same text so many lines farther down; its values without places are the very same objects."""
    if lines == 0:
        return tree
    at = _below(tree.at, lines)
    if isinstance(tree, Scalar):
        return Scalar(tree.value, tree.text, at)
    if isinstance(tree, Row):
        return Row(_Values(tree.items, lines), at, tree.like or tree)
    return Block(_Items(tree.items, lines), at, tree.like or tree)


def _below(at: Location, lines: int) -> Location:
    return at.model_copy(update={"line": (at.line or 0) + lines})


@dataclass(frozen=True, eq=False)
class _Items(Mapping[str, Item]):
    items_above: Mapping[str, Item]
    lines: int

    def __getitem__(self, key: str) -> Item:
        item = self.items_above[key]
        return Item(_below(item.at, self.lines), moved(item.value, self.lines))

    def __iter__(self) -> Iterator[str]:
        return iter(self.items_above)

    def __len__(self) -> int:
        return len(self.items_above)


@dataclass(frozen=True, eq=False)
class _Values(Sequence[Tree]):
    values_above: Sequence[Tree]
    lines: int

    @overload
    def __getitem__(self, at: int) -> Tree: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[Tree, ...]: ...
    def __getitem__(self, at: int | slice) -> Tree | tuple[Tree, ...]:
        found = self.values_above[at]
        return (
            tuple(moved(value, self.lines) for value in found)
            if isinstance(found, Sequence)
            else moved(found, self.lines)
        )

    def __len__(self) -> int:
        return len(self.values_above)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)
