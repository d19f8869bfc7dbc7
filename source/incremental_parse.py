"""Parses an edited text again: only changed entries are parsed, the others are taken from the last run.

A YAML parser in Python takes longer than all other phases of a small edit. A text in plain block style is cut into the
entries of its mappings and lists; an entry that was parsed before is only shifted to its new line. A complete entry
leaves the parser in the state in which it began, so that the parts together give the same tree as the whole text.
Anything else (an incomplete entry, an omitted value, document marks, anchors, tabs, unusual line breaks, duplicate
keys) is left to the parser of whole texts.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from schemas.diagnostics import InvalidInput, Location
from source.line_shifted import line_shifted
from source.numbers import masked, renumbered
from source.parse import MAX_VALUES, Parsed, parse
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping

# Marks of documents, directives and complex keys at the beginning of a line; anchors, odd breaks and what does not
# print anywhere, because comments before an entry are not parsed.
_LEFT_TO_PARSER = (
    re.compile(r"\n(?:---|\.\.\.|%| *[?:](?:[ \n]|$))"),
    re.compile("&|[^\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"),
)
_HEAD = re.compile(r"^( *)([A-Za-z_][A-Za-z0-9_.\-]*):[ ]*(?:[ ]#.*)?$")  # a key whose value begins on the next line


@dataclass
class IncrementalParser:
    """Parser that keeps entries of earlier texts: (first line, tree, number of values) by (file, depth, text).

    `by_masked_text` maps (file, depth, text without its numbers) to the text of such an entry; None until first used.
    """

    entries: dict[tuple[str, int, str], tuple[int, Tree, int]] = field(default_factory=dict)
    entries_in_use: dict[tuple[str, int, str], tuple[int, Tree, int]] = field(default_factory=dict)
    by_masked_text: dict[tuple[str, int, str], str] | None = None

    def parse(self, data: bytes, file: str) -> Parsed:
        """The same result as `parse.parse`, faster when little of the text is new; entries no longer used are
        dropped."""
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            return parse(data, file)
        lines = text.split("\n")
        self.entries_in_use = {}
        cut = (
            None
            if any(mark.search("\n" + text) for mark in _LEFT_TO_PARSER)
            else self._collection(lines, 0, len(lines), 0, file)
        )
        if cut is None or cut[1] > MAX_VALUES:
            return parse(data, file)
        self.entries = {key: entry for key, entry in self.entries.items() if key[0] != file} | self.entries_in_use
        self.by_masked_text = None
        return Parsed(cut[0], (), cut[1])

    def _collection(self, lines: Sequence[str], begin: int, end: int, depth: int, file: str) -> tuple[Tree, int] | None:
        """The mapping or list in lines [begin, end) and its number of values; None where it is not in plain block
        style."""
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
                if leaf is None or not isinstance(leaf[0], TreeList) or len(leaf[0].items) != 1:
                    return None
                rows.append(leaf[0].items[0])
                values += leaf[1] - 1
            return TreeList(tuple(rows), at), values
        items: dict[str, TreeEntry] = {}
        for first, (start, stop) in zip(entries, pairwise(starts), strict=True):
            entry = self._entry(lines, first, start, stop, depth, file)
            if entry is None or entry[0] in items:
                return None
            items[entry[0]] = entry[1]
            values += entry[2]
        return TreeMapping(items, at), values

    def _entry(
        self, lines: Sequence[str], first: int, start: int, stop: int, depth: int, file: str
    ) -> tuple[str, TreeEntry, int] | None:
        """Key, value and number of values of one entry of a mapping; its key is on line `first`."""
        head = _HEAD.match(lines[first])
        if head is not None:
            inner = self._collection(lines, first + 1, stop, depth + 1, file)
            if inner is not None:
                at = Location(file=file, line=first + 1, column=len(head[1]) + 1)
                return head[2], TreeEntry(at, inner[0]), inner[1]
        leaf = self._leaf(lines, start, stop, depth, file)
        if leaf is None or not isinstance(leaf[0], TreeMapping) or len(leaf[0].items) != 1:
            return None
        ((key, item),) = leaf[0].items.items()
        if item.at.column != _indent(lines[first]) + 1:
            return None  # a mapping in braces, which no other entry may follow
        return key, item, leaf[1] - 1

    def _leaf(self, lines: Sequence[str], start: int, stop: int, depth: int, file: str) -> tuple[Tree, int] | None:
        """The tree of these lines alone; None where they are incomplete or have any error."""
        text = "\n".join(lines[start:stop]) + ("\n" if stop < len(lines) else "")
        key = (file, depth, text)
        entry = self.entries.get(key) or self._renumbered(key)
        if entry is None:
            try:
                parsed = parse(text.encode(), file, depth, start)
            except InvalidInput:
                return None
            if parsed.diagnostics or _has_omitted_value(parsed.tree):
                return None
            entry = start, parsed.tree, parsed.values
        self.entries_in_use[key] = entry
        was, tree, values = entry
        return line_shifted(tree, start - was), values

    def _renumbered(self, key: tuple[str, int, str]) -> tuple[int, Tree, int] | None:
        """The entry derived from a known one that differs only in its numbers; None where there is none."""
        if self.by_masked_text is None:
            self.by_masked_text = {(file, depth, masked(text)): text for file, depth, text in self.entries}
        file, depth, text = key
        old = self.by_masked_text.get((file, depth, masked(text)))
        if old is None:
            return None
        was, tree, values = self.entries[file, depth, old]
        edited = renumbered(tree, was, old, text)
        return None if edited is None else (was, edited, values)


def _entries(lines: Sequence[str], begin: int, end: int) -> list[int]:
    """Line numbers on which the entries of one collection begin; empty where they differ in kind or indentation."""
    starts: list[int] = []
    indent, dashed = 0, False
    for number in range(begin, end):
        line = lines[number]
        at = _indent(line)
        if at == len(line) or line[at] == "#":
            continue
        if not starts:
            indent, dashed = at, _is_dash(line, at)
        if at < indent or (at == indent and dashed and not _is_dash(line, at)):
            return []
        if at == indent and dashed == _is_dash(line, at):
            starts.append(number)
    return starts


def _has_omitted_value(tree: Tree) -> bool:
    """Whether some value is omitted: the parser would place it where the next entry begins."""
    if isinstance(tree, Scalar):
        return tree.value is None and not tree.text
    inner = tree.items if isinstance(tree, TreeList) else (item.value for item in tree.items.values())
    return any(_has_omitted_value(value) for value in inner)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _is_dash(line: str, at: int) -> bool:
    return line[at] == "-" and line[at + 1 : at + 2] in ("", " ")
