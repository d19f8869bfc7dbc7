"""Semantic labels of an asset, and the size range (m) of each known category."""

from __future__ import annotations

import csv
import re
from functools import cache
from pathlib import Path
from typing import Any

from pxr import Vt

from gate.subject.values import raw

UNKNOWN = ("unknown", "object", "")  # `object` is the label of an unknown category (usdio.write.package).
_SIZES = Path(__file__).with_name("category_sizes.csv")


def labels(prim: Any) -> dict[str, tuple[str, ...]]:
    """Taxonomy -> labels authored on a prim (UsdSemanticsLabelsAPI)."""
    applied = [s.partition(":")[2] for s in prim.GetAppliedSchemas() if s.startswith("SemanticsLabelsAPI:")]
    labels_by_taxonomy: dict[str, tuple[str, ...]] = {}
    for taxonomy in applied:
        value = raw(prim, f"semantics:labels:{taxonomy}")
        labels_by_taxonomy[taxonomy] = (
            tuple(str(v) for v in value) if isinstance(value, Vt.TokenArray | Vt.StringArray) else ()
        )
    return labels_by_taxonomy


def words(name: str) -> str:
    """A name in lower-case words: `WineGlass_02` and `wine-glass` both become `wine glass`."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return " ".join(re.findall(r"[a-z]+", spaced.lower()))


@cache
def category_sizes() -> dict[str, tuple[float, float]]:
    """Category in words -> plausible (least, largest) longest edge in metres, from `category_sizes.csv`."""
    with _SIZES.open(newline="") as file:
        return {row["category"]: (float(row["least_m"]), float(row["most_m"])) for row in csv.DictReader(file)}


def known_category(name: str) -> str | None:
    """The longest category whose words end the name (`paper cup` is a `cup`), singular or plural; None without one."""
    parts = words(name).split()
    for start in range(len(parts)):
        tail = " ".join(parts[start:])
        for candidate in (tail, tail.removesuffix("s"), tail.removesuffix("es")):
            if candidate in category_sizes():
                return candidate
    return None
