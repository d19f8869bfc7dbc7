"""Parses YAML 1.2 text into a tree whose values carry file, line and column; bounded in bytes, depth and number of
values."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping

MAX_BYTES = 1_000_000
MAX_DEPTH = 60
MAX_BRACKETS = 500
MAX_VALUES = 200_000  # aliases counted out
_PREFIX = "tag:yaml.org,2002:"
_READ = {_PREFIX + kind for kind in ("null", "bool", "int", "float")}
_TEXT = {_PREFIX + kind for kind in ("str", "timestamp", "merge", "value")}


class Parsed(NamedTuple):
    """A tree, findings about single keys and values of it, and how many values it holds."""

    tree: Tree
    diagnostics: tuple[Diagnostic, ...]
    values: int


def parse(data: bytes, file: str, depth: int = 0, line: int = 0) -> Parsed:
    """Parses a text that begins `depth` levels deep and `line` lines down in another; findings name it `file`.

    Raises InvalidInput (`scene/yaml-syntax`, `scene/file-too-large`) when there is no tree.
    """
    if len(data) > MAX_BYTES:
        raise too_large(f"{file} has {len(data)} bytes", Location(file=file), len(data), MAX_BYTES, "bytes")
    try:
        if _open_brackets(data) > MAX_BRACKETS:
            raise RecursionError
        yaml = YAML(typ="safe", pure=True)
        root = yaml.compose(data.decode("utf-8-sig"))
        reader = _Reader(file, yaml, line)
        empty = TreeMapping({}, Location(file=file, line=1, column=1))
        return Parsed(reader.tree(root, depth) if root is not None else empty, tuple(reader.diagnostics), reader.values)
    except MarkedYAMLError as error:
        unclosed = error.context is not None and "flow" in error.context  # shown where the bracket was opened
        mark = (error.context_mark if unclosed else None) or error.problem_mark or error.context_mark
        where = Location(file=file, line=mark.line + 1, column=mark.column + 1) if mark else Location(file=file)
        problem = error.problem or error.context or "unreadable"
    except UnicodeDecodeError as error:
        where, problem = Location(file=file, line=data[: error.start].count(b"\n") + 1), "the text is not UTF-8"
    except RecursionError:
        raise too_large(f"{file} is nested too deeply", Location(file=file), None, MAX_DEPTH, "levels") from None
    except (YAMLError, ValueError, LookupError, AttributeError) as error:  # the library's own, for odd directives
        where, problem = Location(file=file), (str(error).splitlines() or [type(error).__name__])[0]
    raise InvalidInput(finding("scene/yaml-syntax", problem, where=where))


def too_large(headline: str, where: Location, value: float | None, bound: float, unit: str) -> InvalidInput:
    """The error for a text that exceeds a size bound."""
    return InvalidInput(finding("scene/file-too-large", headline, where=where, value=value, bound=bound, unit=unit))


def _open_brackets(data: bytes) -> int:
    """The largest number of brackets open at once, or an upper bound of it that is at most MAX_BRACKETS.

    Brackets in comments and strings are counted as well; the limit is high enough for that. The parser's time grows
    with the square of this number.
    """
    if (most := data.count(b"[") + data.count(b"{")) <= MAX_BRACKETS:
        return most
    steps = np.frombuffer(data, dtype=np.uint8)
    change = np.isin(steps, list(b"[{")).astype(np.int64) - np.isin(steps, list(b"]}"))
    return int(np.cumsum(change).max(initial=0))


class _Reader:
    """Turns syntax nodes into the tree. An alias is read once and counts in full at every place where it is used."""

    def __init__(self, file: str, yaml: YAML, line: int) -> None:
        self.file, self.yaml, self.line = file, yaml, line
        self.diagnostics: list[Diagnostic] = []
        self.values = self.deepest = 0
        self._read: dict[int, tuple[Tree, int, int]] = {}  # by node: its tree, how many values it holds, its depth

    def tree(self, node: Node, depth: int) -> Tree:
        tree, values, height = self._read.get(id(node), (None, 0, 0))
        self.values += max(values, 1)
        if self.values > MAX_VALUES:
            raise too_large("the program holds too many values", self._at(node), None, MAX_VALUES, "values")
        if depth + height > MAX_DEPTH:  # An alias inside its own anchor ends here, too.
            raise too_large(f"{self.file} is nested too deeply", self._at(node), depth + height, MAX_DEPTH, "levels")
        self.deepest = max(self.deepest, depth + height)
        if tree is None:
            outside, self.deepest, before = self.deepest, depth, self.values
            tree = self._new(node, depth)
            self._read[id(node)] = tree, self.values - before + 1, self.deepest - depth
            self.deepest = max(outside, self.deepest)
        return tree

    def _new(self, node: Node, depth: int) -> Tree:
        at = self._at(node)
        if isinstance(node, MappingNode):
            return self._block(node, at, depth)
        if isinstance(node, SequenceNode):
            return TreeList(tuple(self.tree(item, depth + 1) for item in node.value), at)
        assert isinstance(node, ScalarNode), "YAML has three kinds of nodes"
        return self._scalar(node, at)

    def _block(self, node: MappingNode, at: Location, depth: int) -> TreeMapping:
        items: dict[str, TreeEntry] = {}
        for key, value in node.value:
            here = self._at(key)
            if not isinstance(key, ScalarNode):
                self.diagnostics.append(finding("scene/yaml-syntax", "a key is a list or a mapping", where=here))
            elif key.value in items:
                self.diagnostics.append(
                    finding("scene/yaml-syntax", f"the key `{key.value}` stands here twice", where=here)
                )
            else:
                items[key.value] = TreeEntry(here, self.tree(value, depth + 1))
        return TreeMapping(items, at)

    def _scalar(self, node: ScalarNode, at: Location) -> Scalar:
        tag = str(node.tag)
        if tag in _READ:
            return Scalar(self.yaml.constructor.construct_object(node), node.value, at)
        if tag not in _TEXT:
            self.diagnostics.append(finding("scene/yaml-syntax", f"the tag `{tag}` has no meaning here", where=at))
        return Scalar(node.value, node.value, at)

    def _at(self, node: Node) -> Location:
        return Location(file=self.file, line=self.line + node.start_mark.line + 1, column=node.start_mark.column + 1)
