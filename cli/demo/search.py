"""Two requests in plain words to the library of the demo, and why each hit was found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from assetkit.library import catalog
from assetkit.library.search.parse_query import read_request
from assetkit.library.search.search import Found, search

REQUESTS = ("mug I can pour from", "something I can put things into, under 1 kg")


@dataclass(frozen=True)
class SearchDemo:
    """A request and what `mana assets search` finds for it."""

    request: str
    found: Found


def search_demo(library: Path) -> tuple[SearchDemo, ...]:
    """The answers of the `library` just made to `REQUESTS`."""
    assets = catalog.facts(library)
    return tuple(
        SearchDemo(request, search(assets, read_request(request), lambda wish: catalog.find_text(library, wish)))
        for request in REQUESTS
    )
