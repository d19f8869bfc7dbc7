"""Prim and file names: valid, unique, and with the way back to the source name."""

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


def prim_names(names: Iterable[str], fallback: str) -> dict[str, str]:
    """Unique prim names for siblings, in the order of `names`: prim name -> source name.

    Names that would differ in letter case alone count as equal, because they also become file names. Later ones get
    `_2`, `_3` ... A name that already is a unique identifier is kept.
    """
    sources = list(names)
    wanted = [identifier(name, fallback) for name in sources]
    # Exact names keep theirs even when an earlier, altered name would have taken it.
    reserved = {w.lower() for w, name in zip(wanted, sources, strict=True) if w == name}
    taken: set[str] = set()
    result: dict[str, str] = {}
    for want, name in zip(wanted, sources, strict=True):
        chosen, count = want, 1
        while chosen.lower() in taken or (chosen.lower() in reserved and chosen != name):
            count += 1
            chosen = f"{want}_{count}"
        taken.add(chosen.lower())
        result[chosen] = name
    return result
