"""Reads values of a mapping by key and collects what is wrong with them, each finding at its place."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from schemas.diagnostics import Diagnostic, Location, finding
from source.hint import did_you_mean
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping

LONGEST_SHOWN = 60


class MappingReader:
    """The entries of one mapping; `what` names it in findings, which go to `findings` with codes of an area."""

    def __init__(self, tree: TreeMapping, what: str, findings: list[Diagnostic], *, area: str = "task") -> None:
        self.tree, self.what, self.findings, self.area = tree, what, findings, area

    def refuse_other_keys(self, known: Sequence[str]) -> None:
        """A finding for each key that is not known."""
        for key, entry in self.tree.items.items():
            if key not in known:
                takes = did_you_mean(key, known) or f"; it takes {', '.join(known)}"
                headline = f"`{key}` is not a key of {self.what}{takes}"
                self.findings.append(
                    finding(f"{self.area}/unknown-key", headline, where=entry.at, value=key, bound=", ".join(known))
                )

    def entry(self, key: str, *, needed: bool = False) -> TreeEntry | None:
        """The entry of a key, None where there is none; a finding where it is needed."""
        entry = self.tree.items.get(key)
        if entry is None and needed:
            self.findings.append(finding(f"{self.area}/missing-key", f"{self.what} needs `{key}`", where=self.tree.at))
        return entry

    def text(self, key: str, *, needed: bool = False) -> str | None:
        """A text; numbers count as the text that they are written as."""
        entry = self.entry(key, needed=needed)
        if entry is None:
            return None
        if isinstance(entry.value, Scalar) and entry.value.value is not None:
            return entry.value.text
        self.wrong(key, "takes a text", entry)
        return None

    def number(self, key: str, *, above: float) -> float | None:
        """A finite number above a bound."""
        entry = self.entry(key)
        if entry is None:
            return None
        value = entry.value.value if isinstance(entry.value, Scalar) else None
        if isinstance(value, int | float) and not isinstance(value, bool) and above < value < float("inf"):
            return float(value)
        self.wrong(key, f"takes a number above {above:g}", entry)
        return None

    def exact(self, key: str) -> Fraction | None:
        """A positive number as it is written, without rounding."""
        entry = self.entry(key)
        if entry is None:
            return None
        if self._is_number(entry.value) and isinstance(entry.value, Scalar):
            try:
                value = Fraction(entry.value.text)
            except ValueError:
                value = Fraction(0)
            if value > 0:
                return value
        self.wrong(key, "takes a number above 0", entry)
        return None

    def flag(self, key: str) -> bool:
        """`true` or `false`; false where it is absent."""
        entry = self.entry(key)
        if entry is None:
            return False
        if isinstance(entry.value, Scalar) and isinstance(entry.value.value, bool):
            return entry.value.value
        self.wrong(key, "takes true or false", entry)
        return False

    def mapping(self, key: str, *, needed: bool = False) -> TreeMapping | None:
        """A mapping."""
        entry = self.entry(key, needed=needed)
        if entry is None or isinstance(entry.value, TreeMapping):
            return entry.value if entry is not None and isinstance(entry.value, TreeMapping) else None
        self.wrong(key, "takes a mapping", entry)
        return None

    def list(self, key: str, *, needed: bool = False) -> Sequence[Tree]:
        """The items of a list; empty where it is absent."""
        entry = self.entry(key, needed=needed)
        if entry is None:
            return ()
        if isinstance(entry.value, TreeList):
            return entry.value.items
        self.wrong(key, "takes a list", entry)
        return ()

    def wrong(self, key: str, takes: str, entry: TreeEntry) -> None:
        """A finding about the value of a key."""
        code, headline = f"{self.area}/invalid-value", f"`{key}` of {self.what} {takes}"
        self.findings.append(finding(code, headline, where=place(entry), value=shown(entry.value)))

    @staticmethod
    def _is_number(tree: Tree) -> bool:
        return isinstance(tree, Scalar) and isinstance(tree.value, int | float) and not isinstance(tree.value, bool)


def in_text_order(findings: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Findings by file, line and column."""
    return tuple(sorted(findings, key=lambda d: (d.where.file or "", d.where.line or 0, d.where.column or 0)))


def place(entry: TreeEntry) -> Location:
    """Where a value stands: its own place, or that of its key where it is a mapping or list."""
    return entry.value.at if isinstance(entry.value, Scalar) else entry.at


def shown(tree: Tree) -> Any:
    """A value as a finding shows it."""
    return tree.text[:LONGEST_SHOWN] if isinstance(tree, Scalar) else None
