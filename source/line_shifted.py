"""Views of a syntax tree shifted down by a number of lines; locations are computed on access, so that shifting is
O(1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

from schemas.diagnostics import Location
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping


def line_shifted(tree: Tree, lines: int) -> Tree:
    """The tree of the same text `lines` farther down; its plain values stay the same Python objects."""
    if lines == 0:
        return tree
    at = _below(tree.at, lines)
    if isinstance(tree, Scalar):
        return Scalar(tree.value, tree.text, at)
    if isinstance(tree, TreeList):
        return TreeList(_Values(tree.items, lines), at, tree.original or tree)
    return TreeMapping(_Items(tree.items, lines), at, tree.original or tree)


def _below(at: Location, lines: int) -> Location:
    return at.model_copy(update={"line": (at.line or 0) + lines})


@dataclass(frozen=True, eq=False)
class _Items(Mapping[str, TreeEntry]):
    unshifted: Mapping[str, TreeEntry]
    lines: int

    def __getitem__(self, key: str) -> TreeEntry:
        item = self.unshifted[key]
        return TreeEntry(_below(item.at, self.lines), line_shifted(item.value, self.lines))

    def __iter__(self) -> Iterator[str]:
        return iter(self.unshifted)

    def __len__(self) -> int:
        return len(self.unshifted)


@dataclass(frozen=True, eq=False)
class _Values(Sequence[Tree]):
    unshifted: Sequence[Tree]
    lines: int

    @overload
    def __getitem__(self, at: int) -> Tree: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[Tree, ...]: ...
    def __getitem__(self, at: int | slice) -> Tree | tuple[Tree, ...]:
        values = self.unshifted[at]
        return (
            tuple(line_shifted(value, self.lines) for value in values)
            if isinstance(values, Sequence)
            else line_shifted(values, self.lines)
        )

    def __len__(self) -> int:
        return len(self.unshifted)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)
