"""A text read again: only what changed since the last time is parsed, the rest is taken from there.

A YAML parser in Python takes longer than all other phases of a small edit. Where a text is plain block style, it is cut
into the entries of its mappings and lists; an entry that was parsed before is only moved to its line. An entry that is
whole by itself leaves the parser in the state in which it began, so that the parts together are what the whole text
gives. Anything else (an entry that is not whole, a value left out, marks of documents, anchors, tabs, odd line breaks,
keys that stand twice) is left to the parser of whole texts.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from scenec.source.line_shifted import moved
from scenec.source.numbers import masked, renumbered
from scenec.source.parse import MAX_VALUES, Parsed, parse
from scenec.source.tree import Block, Item, Row, Scalar, Tree
from schemas.diagnostics import InvalidInput, Location

# Marks of documents, directives and complex keys at the beginning of a line; anchors, odd breaks and what does not
# print anywhere, because comments before an entry are not parsed.
_LEFT_TO_PARSER = (
    re.compile(r"\n(?:---|\.\.\.|%| *[?:](?:[ \n]|$))"),
    re.compile("&|[^\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"),
)
_HEAD = re.compile(r"^( *)([A-Za-z_][A-Za-z0-9_.\-]*):[ ]*(?:[ ]#.*)?$")  # a key whose value begins on the next line


@dataclass
class Pieces:
    """Entries of texts parsed before: tree and number of values by (file, depth, text), each with its first line.

    `alike` has the text of such an entry by (file, depth, text without its numbers), None until it is asked for.
    """

    known: dict[tuple[str, int, str], tuple[int, Tree, int]] = field(default_factory=dict)
    used: dict[tuple[str, int, str], tuple[int, Tree, int]] = field(default_factory=dict)
    alike: dict[tuple[str, int, str], str] | None = None

    def parse(self, data: bytes, file: str) -> Parsed:
        """The same as `parse.parse`, faster when little of the text is new; what it no longer holds is forgotten."""
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            return parse(data, file)
        lines = text.split("\n")
        self.used = {}
        cut = (
            None
            if any(mark.search("\n" + text) for mark in _LEFT_TO_PARSER)
            else self._collection(lines, 0, len(lines), 0, file)
        )
        if cut is None or cut[1] > MAX_VALUES:
            return parse(data, file)
        self.known = {key: entry for key, entry in self.known.items() if key[0] != file} | self.used
        self.alike = None
        return Parsed(cut[0], (), cut[1])

    def _collection(self, lines: Sequence[str], begin: int, end: int, depth: int, file: str) -> tuple[Tree, int] | None:
        """The mapping or list in lines [begin, end) and how many values it holds; None where it is not plainly one."""
        entries = _entries(lines, begin, end)
        if not entries:
            return None
        indent, values = _indent(lines[entries[0]]), 1
        at = Location(file=file, line=entries[0] + 1, column=indent + 1)
        starts = [*entries, end]
        if lines[entries[0]][indent] == "-":
            rows: list[Tree] = []
            for start, stop in pairwise(starts):
                leaf = self._leaf(lines, start, stop, depth, file)
                if leaf is None or not isinstance(leaf[0], Row) or len(leaf[0].items) != 1:
                    return None
                rows.append(leaf[0].items[0])
                values += leaf[1] - 1
            return Row(tuple(rows), at), values
        items: dict[str, Item] = {}
        for first, (start, stop) in zip(entries, pairwise(starts), strict=True):
            entry = self._entry(lines, first, start, stop, depth, file)
            if entry is None or entry[0] in items:
                return None
            items[entry[0]] = entry[1]
            values += entry[2]
        return Block(items, at), values

    def _entry(
        self, lines: Sequence[str], first: int, start: int, stop: int, depth: int, file: str
    ) -> tuple[str, Item, int] | None:
        """Key, value and number of values of one entry of a mapping; its key is on line `first`."""
        head = _HEAD.match(lines[first])
        if head is not None:
            inner = self._collection(lines, first + 1, stop, depth + 1, file)
            if inner is not None:
                at = Location(file=file, line=first + 1, column=len(head[1]) + 1)
                return head[2], Item(at, inner[0]), inner[1]
        leaf = self._leaf(lines, start, stop, depth, file)
        if leaf is None or not isinstance(leaf[0], Block) or len(leaf[0].items) != 1:
            return None
        ((key, item),) = leaf[0].items.items()
        if item.at.column != _indent(lines[first]) + 1:
            return None  # a mapping in braces, which no other entry may follow
        return key, item, leaf[1] - 1

    def _leaf(self, lines: Sequence[str], start: int, stop: int, depth: int, file: str) -> tuple[Tree, int] | None:
        """What the lines hold by themselves; None where they are not whole or anything is wrong with them."""
        text = "\n".join(lines[start:stop]) + ("\n" if stop < len(lines) else "")
        key = (file, depth, text)
        entry = self.known.get(key) or self._renumbered(key)
        if entry is None:
            try:
                parsed = parse(text.encode(), file, depth, start)
            except InvalidInput:
                return None
            if parsed.diagnostics or _says_nothing(parsed.tree):
                return None
            entry = start, parsed.tree, parsed.values
        self.used[key] = entry
        was, tree, values = entry
        return moved(tree, start - was), values

    def _renumbered(self, key: tuple[str, int, str]) -> tuple[int, Tree, int] | None:
        """The entry made of one that differs in numbers alone, None where none is known."""
        if self.alike is None:
            self.alike = {(file, depth, masked(text)): text for file, depth, text in self.known}
        file, depth, text = key
        old = self.alike.get((file, depth, masked(text)))
        if old is None:
            return None
        was, tree, values = self.known[file, depth, old]
        made = renumbered(tree, was, old, text)
        return None if made is None else (was, made, values)


def _entries(lines: Sequence[str], begin: int, end: int) -> list[int]:
    """Lines on which the entries of one collection begin; none where they are not of one kind at one indentation."""
    found: list[int] = []
    indent, dashed = 0, False
    for number in range(begin, end):
        line = lines[number]
        at = _indent(line)
        if at == len(line) or line[at] == "#":
            continue
        if not found:
            indent, dashed = at, _is_dash(line, at)
        if at < indent or (at == indent and dashed and not _is_dash(line, at)):
            return []
        if at == indent and dashed == _is_dash(line, at):
            found.append(number)
    return found


def _says_nothing(tree: Tree) -> bool:
    """Whether some value is left out: the parser then says that it stands where the next entry begins."""
    if isinstance(tree, Scalar):
        return tree.value is None and not tree.text
    inner = tree.items if isinstance(tree, Row) else (item.value for item in tree.items.values())
    return any(_says_nothing(value) for value in inner)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _is_dash(line: str, at: int) -> bool:
    return line[at] == "-" and line[at + 1 : at + 2] in ("", " ")
