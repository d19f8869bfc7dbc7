"""Identifiers from source names: ASCII words, unique among siblings whatever their case, mapped to their source.

They serve as ids of meshes, as USD prim names and as file names.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

_INVALID = re.compile(r"[^A-Za-z0-9_]+")


def identifier(name: str, fallback: str) -> str:
    """`name` as an ASCII identifier (letters, digits, underscores, no leading digit), or `fallback` if nothing is left.

    Accents are dropped ("é" -> "e"), every other run of foreign characters becomes one underscore. USD itself allows
    Unicode identifiers; SimReady NP.001 and many importers do not.
    """
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    text = _INVALID.sub("_", plain).strip("_")
    if not text:
        return fallback
    return f"_{text}" if text[0].isdigit() else text


def unique_identifiers(names: Iterable[str], fallback: str) -> dict[str, str]:
    """Unique identifiers for siblings, in the order of `names`: identifier -> source name.

    Names that would differ in letter case alone count as equal, because they also become file names. Later ones get
    `_2`, `_3` ... A name that already is a unique identifier is kept.
    """
    sources = list(names)
    candidates = [identifier(name, fallback) for name in sources]
    # A source name that is already valid is kept, even where an earlier, altered name would have become the same.
    reserved = {c.lower() for c, name in zip(candidates, sources, strict=True) if c == name}
    taken: set[str] = set()
    source_of: dict[str, str] = {}
    for candidate, name in zip(candidates, sources, strict=True):
        chosen, count = candidate, 1
        while chosen.lower() in taken or (chosen.lower() in reserved and chosen != name):
            count += 1
            chosen = f"{candidate}_{count}"
        taken.add(chosen.lower())
        source_of[chosen] = name
    return source_of
