"""Two requests in plain words to the library of the demo, and why each hit was found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from assetkit.library import catalog
from assetkit.library.search.parse_query import parse_query
from assetkit.library.search.search import SearchResult, search

REQUESTS = ("mug I can pour from", "something I can put things into, under 1 kg")


@dataclass(frozen=True)
class SearchDemo:
    """A request and what `mana assets search` finds for it."""

    request: str
    found: SearchResult


def search_demo(library: Path) -> tuple[SearchDemo, ...]:
    """The answers of the `library` just made to `REQUESTS`."""
    assets = catalog.facts(library)
    return tuple(
        SearchDemo(
            request, search(assets, parse_query(request), lambda criterion: catalog.find_text(library, criterion))
        )
        for request in REQUESTS
    )
