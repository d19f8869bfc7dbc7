"""The text of a program as a tree in which every value remembers where it was written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from scenec.ir.problem import Path
from schemas.diagnostics import Location


@dataclass(frozen=True)
class Scalar:
    """A single value, and its text as written (`007` is the number 7 and the text `007`)."""

    value: bool | int | float | str | None
    text: str
    at: Location


@dataclass(frozen=True)
class Item:
    """One entry of a mapping: where its key stands, and its value."""

    at: Location
    value: Tree


@dataclass(frozen=True)
class Block:
    """A mapping, in the order of the text. `like` is the same elsewhere in a text (see
    `scenec.source.line_shifted`).
    """

    items: Mapping[str, Item]
    at: Location
    like: Block | None = field(default=None, repr=False, compare=False)

    @cached_property
    def has_rules(self) -> bool:
        """Whether a key in it is a rule for overlays, such as `$append`."""
        if self.like is not None:
            return self.like.has_rules
        return any(key[:1] == "$" or _has_rules(item.value) for key, item in self.items.items())

    @cached_property
    def plain(self) -> dict[str, Any]:
        """The same without places in the text: one object wherever the text stands."""
        if self.like is not None:
            return self.like.plain
        return {key: plain(item.value) for key, item in self.items.items()}


@dataclass(frozen=True)
class Row:
    """A list. `like` is the same elsewhere in a text (see `scenec.source.line_shifted`)."""

    items: Sequence[Tree]
    at: Location
    like: Row | None = field(default=None, repr=False, compare=False)

    @cached_property
    def has_rules(self) -> bool:
        """Whether a key in it is a rule for overlays."""
        if self.like is not None:
            return self.like.has_rules
        return any(map(_has_rules, self.items))

    @cached_property
    def plain(self) -> list[Any]:
        """The same without places in the text: one object wherever the text stands."""
        if self.like is not None:
            return self.like.plain
        return [plain(item) for item in self.items]


Tree: TypeAlias = Scalar | Block | Row


def _has_rules(tree: Tree) -> bool:
    return not isinstance(tree, Scalar) and tree.has_rules


@dataclass(frozen=True)
class Spans:
    """Where each value of a program stands in its files."""

    tree: Tree | None = None
    file: str | None = None

    def place(self, path: Path = ()) -> Location:
        """File, line and column of what stands at `path`, or of the deepest part of it that exists.

        A single value begins where it is written, a mapping or list at its key.
        """
        at, node = Location(file=self.file, line=1, column=1), self.tree
        for step in path:
            if isinstance(node, Block) and str(step) in node.items:
                item = node.items[str(step)]
                at, node = item.value.at if isinstance(item.value, Scalar) else item.at, item.value
            elif isinstance(node, Row) and isinstance(step, int) and step < len(node.items):
                node = node.items[step]
                at = node.at
            else:
                break
        return at

    def key(self, path: Path) -> Location:
        """Where the last key of `path` stands."""
        node = child(self.tree, path[:-1])
        if path and isinstance(node, Block) and str(path[-1]) in node.items:
            return node.items[str(path[-1])].at
        return self.place(path)


def child(tree: Tree | None, path: Path) -> Tree | None:
    """What stands at `path`, None where nothing does."""
    for step in path:
        if isinstance(tree, Block) and str(step) in tree.items:
            tree = tree.items[str(step)].value
        elif isinstance(tree, Row) and isinstance(step, int) and step < len(tree.items):
            tree = tree.items[step]
        else:
            return None
    return tree


def plain(tree: Tree) -> Any:
    """The tree as dicts, lists and values; not to be changed, for the tree keeps it."""
    return tree.value if isinstance(tree, Scalar) else tree.plain


def written(path: Path) -> str:
    """A path as people write it: `relations[2].gap`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
