"""Syntax tree of a YAML file: scalars, lists and mappings, each with its location (file, line, column)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from schemas.diagnostics import Location

Path: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the root to a value: `("objects", 2, "id")`."""


@dataclass(frozen=True)
class Scalar:
    """A single value, and its text as written (`007` is the number 7 and the text `007`)."""

    value: bool | int | float | str | None
    text: str
    at: Location


@dataclass(frozen=True)
class TreeEntry:
    """One entry of a mapping: the location of its key, and its value."""

    at: Location
    value: Tree


@dataclass(frozen=True)
class TreeMapping:
    """A mapping, in the order of the text. `original` is the tree that this one is a line-shifted copy of, if any (see
    `source.line_shifted`).
    """

    items: Mapping[str, TreeEntry]
    at: Location
    original: TreeMapping | None = field(default=None, repr=False, compare=False)

    @cached_property
    def has_overlay_rules(self) -> bool:
        """Whether it holds an overlay rule such as `$append` at any depth."""
        if self.original is not None:
            return self.original.has_overlay_rules
        return any(key[:1] == "$" or _has_overlay_rules(item.value) for key, item in self.items.items())

    @cached_property
    def plain(self) -> dict[str, Any]:
        """The same without locations: one object, shared by all line-shifted copies."""
        if self.original is not None:
            return self.original.plain
        return {key: plain(item.value) for key, item in self.items.items()}


@dataclass(frozen=True)
class TreeList:
    """A list. `original` as for `TreeMapping`."""

    items: Sequence[Tree]
    at: Location
    original: TreeList | None = field(default=None, repr=False, compare=False)

    @cached_property
    def has_overlay_rules(self) -> bool:
        """Whether it holds an overlay rule at any depth."""
        if self.original is not None:
            return self.original.has_overlay_rules
        return any(map(_has_overlay_rules, self.items))

    @cached_property
    def plain(self) -> list[Any]:
        """The same without locations: one object, shared by all line-shifted copies."""
        if self.original is not None:
            return self.original.plain
        return [plain(item) for item in self.items]


Tree: TypeAlias = Scalar | TreeMapping | TreeList


def _has_overlay_rules(tree: Tree) -> bool:
    return not isinstance(tree, Scalar) and tree.has_overlay_rules


@dataclass(frozen=True)
class Spans:
    """Locations of the values of a program in its files, by path."""

    tree: Tree | None = None
    file: str | None = None
    aliases: Mapping[Path, Path] = field(default_factory=dict[Path, Path])  # of generated parts: where they come from

    def place(self, path: Path = ()) -> Location:
        """Location of the value at `path`, or of the deepest part of the path that exists.

        That of a scalar is its own, that of a mapping or list is the location of its key.
        """
        at, node = Location(file=self.file, line=1, column=1), self.tree
        for step in self._written(path):
            if isinstance(node, TreeMapping) and str(step) in node.items:
                item = node.items[str(step)]
                at, node = item.value.at if isinstance(item.value, Scalar) else item.at, item.value
            elif isinstance(node, TreeList) and isinstance(step, int) and step < len(node.items):
                node = node.items[step]
                at = node.at
            else:
                break
        return at

    def key(self, path: Path) -> Location:
        """Location of the last key of `path`."""
        path = self._written(path)
        node = child(self.tree, path[:-1])
        if path and isinstance(node, TreeMapping) and str(path[-1]) in node.items:
            return node.items[str(path[-1])].at
        return self.place(path)

    def _written(self, path: Path) -> Path:
        for length in range(min(len(path), 3), 1, -1) if self.aliases else ():
            if path[:length] in self.aliases:
                return (*self.aliases[path[:length]], *path[length:])
        return path


def child(tree: Tree | None, path: Path) -> Tree | None:
    """The subtree at `path`, None where there is none."""
    for step in path:
        if isinstance(tree, TreeMapping) and str(step) in tree.items:
            tree = tree.items[str(step)].value
        elif isinstance(tree, TreeList) and isinstance(step, int) and step < len(tree.items):
            tree = tree.items[step]
        else:
            return None
    return tree


def plain(tree: Tree) -> Any:
    """The tree as dicts, lists and values. Callers must not change it: the tree caches it."""
    return tree.value if isinstance(tree, Scalar) else tree.plain


def written(path: Path) -> str:
    """A path as text: `relations[2].gap`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
