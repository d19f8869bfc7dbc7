"""Compares two recordings file by file: which values differ, by how much, and what is in one of them only."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, Literal, TypeGuard

import numpy as np

from tools.golden.content import Roots, read

Kind = Literal["number", "words", "pixels", "structure", "missing", "extra"]
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_SHOWN = 160  # characters of a value


@dataclass(frozen=True)
class Difference:
    """One place of a file, such as `$.physics.mass_kg.value` or `line 12`; `most` is the largest numeric difference."""

    kind: Kind
    where: str
    old: str = ""
    new: str = ""
    most: float | None = None

    def __str__(self) -> str:
        values = f": {self.old} -> {self.new}" if self.old or self.new else ""
        by = "" if self.most is None else f" (by {self.most:.3g})"
        return f"{self.where} [{self.kind}]{values}{by}"


@dataclass(frozen=True)
class Comparison:
    """Files compared, those with differences, those with other bytes but equal content, and cases of one side only."""

    files: int
    differing: dict[str, list[Difference]]
    same_content: list[str]
    not_compared: dict[str, str]

    @property
    def equal(self) -> bool:
        """Whether nothing differs; cases that were not compared do not count."""
        return not self.differing


def compare_cases(
    old: Path, new: Path, cases: Sequence[str], roots: tuple[Roots, Roots], not_compared: dict[str, str]
) -> Comparison:
    """Compare the cases below two `outputs` folders; `roots` are the paths that old and new files may name."""
    files = 0
    differing: dict[str, list[Difference]] = {}
    same: list[str] = []
    for case in cases:
        names = [{p.relative_to(at).as_posix() for p in (at / case).rglob("*") if p.is_file()} for at in (old, new)]
        for at in sorted(names[0] | names[1]):
            files += 1
            if at not in names[0] or at not in names[1]:
                kind: Kind = "missing" if at not in names[1] else "extra"
                differing[at] = [Difference(kind, "the file")]
            elif (old / at).read_bytes() != (new / at).read_bytes():
                found = list(compare_files(old / at, new / at, roots, schema=case.startswith("schemas/")))
                if found:
                    differing[at] = found
                else:
                    same.append(at)
    return Comparison(files, differing, same, not_compared)


def compare_files(old: Path, new: Path, roots: tuple[Roots, Roots], schema: bool = False) -> Iterator[Difference]:
    """Differences of content; none where only seconds, versions or paths differ."""
    before, after = read(old, roots[0], schema), read(new, roots[1], schema)
    if isinstance(before, list) and isinstance(after, list) and old.suffix.lower() != ".json":
        yield from of_lines(before, after)
    elif isinstance(before, bytes) or isinstance(after, bytes):
        yield Difference("words", "the bytes")
    else:
        yield from of_values(before, after, "$")


def of_lines(old: Sequence[str], new: Sequence[str]) -> Iterator[Difference]:
    """Line by line; lines that differ in numbers only say by how much."""
    if len(old) != len(new):
        yield Difference("structure", "number of lines", str(len(old)), str(len(new)))
    for k, (before, after) in enumerate(zip_longest(old, new, fillvalue=""), start=1):
        if before == after:
            continue
        numbers = _NUMBER.sub("#", before) == _NUMBER.sub("#", after)
        pairs = zip(_NUMBER.findall(before), _NUMBER.findall(after), strict=True) if numbers else ()
        most = max((abs(float(a) - float(b)) for a, b in pairs), default=None)
        yield Difference("number" if numbers else "words", f"line {k}", *_shown_near(before, after), most)
        if len(old) != len(new):
            return  # all later lines would differ


def of_values(old: Any, new: Any, where: str) -> Iterator[Difference]:
    """JSON values, and arrays by name, each under its path."""
    if isinstance(old, np.ndarray) and isinstance(new, np.ndarray):
        yield from _of_arrays(old, new, where)
    elif isinstance(old, dict) and isinstance(new, dict):
        yield from _of_mappings(old, new, where)
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield Difference("structure", where, f"{len(old)} items", f"{len(new)} items")
        for k, (before, after) in enumerate(zip(old, new, strict=False)):
            yield from of_values(before, after, f"{where}[{k}]")
    elif _is_number(old) and _is_number(new):
        if type(old) is not type(new):
            yield Difference("structure", where, repr(old), repr(new), abs(old - new))
        elif old != new and not (math.isnan(old) and math.isnan(new)):
            yield Difference("number", where, repr(old), repr(new), abs(old - new))
    elif isinstance(old, str) and isinstance(new, str):
        if old != new:
            yield Difference("words", where, *_shown_near(old, new))
    elif type(old) is not type(new) or old != new:
        yield Difference("structure", where, _shown(old), _shown(new))


def _of_mappings(old: Mapping[str, Any], new: Mapping[str, Any], where: str) -> Iterator[Difference]:
    for key in dict.fromkeys([*old, *new]):
        at = f"{where}.{key}"
        if key not in new:
            yield Difference("missing", at, _shown(old[key]))
        elif key not in old:
            yield Difference("extra", at, "", _shown(new[key]))
        else:
            yield from of_values(old[key], new[key], at)


def _of_arrays(old: np.ndarray, new: np.ndarray, where: str) -> Iterator[Difference]:
    if (old.shape, old.dtype) != (new.shape, new.dtype):
        yield Difference("structure", where, f"{old.dtype}{old.shape}", f"{new.dtype}{new.shape}")
        return
    if not np.issubdtype(old.dtype, np.number):
        if not np.array_equal(old, new):
            at = np.argwhere(old != new)[0].tolist() if old.ndim else []
            yield Difference("words", f"{where}{at}", _shown(old[tuple(at)]), _shown(new[tuple(at)]))
        return
    unequal = (old != new) & ~(np.isnan(old) & np.isnan(new))
    if not unequal.any():
        return
    most = float(np.max(np.abs(old[unequal].astype(np.float64) - new[unequal].astype(np.float64))))
    if where == "$.pixels":
        share = unequal.any(axis=-1).mean() if old.ndim == 3 else unequal.mean()
        yield Difference("pixels", "picture", "", f"{100.0 * share:.3g} % of the pixels differ", most)
        return
    at = tuple(np.argwhere(unequal)[0].tolist())
    shown = f"{unequal.sum()} of {unequal.size} values of {where}, first at {list(at)}"
    yield Difference("number", shown, str(old[at]), str(new[at]), most)


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: object) -> str:
    text = str(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _shown_near(old: str, new: str) -> tuple[str, str]:
    """Both texts from shortly before the first character that differs."""
    first = next((k for k, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), min(len(old), len(new)))
    start = max(0, first - 40)
    cut = "..." if start else ""
    return cut + repr(_shown(old[start:])), cut + repr(_shown(new[start:]))
