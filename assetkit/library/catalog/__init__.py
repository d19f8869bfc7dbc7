"""The catalog of a library: rows made from its records, for lists, counts, search and near-duplicates."""

from assetkit.library.catalog.collection import collection
from assetkit.library.catalog.listing import ALL, Selection, counts, listing, values_of
from assetkit.library.catalog.search import facts, find_text, search_catalog
from assetkit.library.catalog.store import CATALOG, fingerprints, reading, rebuild, records, update

__all__ = [
    "ALL",
    "CATALOG",
    "Selection",
    "collection",
    "counts",
    "facts",
    "find_text",
    "fingerprints",
    "listing",
    "reading",
    "rebuild",
    "records",
    "search_catalog",
    "update",
    "values_of",
]
