"""Two requests in plain words to the library of the demo, and why each hit was found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from assetkit.library import catalog
from assetkit.library.search.parse_query import parse_query
from assetkit.library.search.search import SearchResult

REQUESTS = ("mug I can pour from", "something I can put things into, under 1 kg")
MAX_SHOWN = 3


@dataclass(frozen=True)
class SearchDemo:
    """A request and what `mana assets search` finds for it."""

    request: str
    found: SearchResult


def search_demo(library: Path) -> tuple[SearchDemo, ...]:
    """The answers of the `library` just made to `REQUESTS`."""
    return tuple(
        SearchDemo(request, catalog.search_catalog(library, parse_query(request), MAX_SHOWN)) for request in REQUESTS
    )
