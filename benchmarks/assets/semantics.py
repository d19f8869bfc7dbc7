"""Counts how often the embedded annotator is right, without an answer, or wrong.

    python -m benchmarks.assets.semantics ASSETS_DIR [--only TEXT]
    python -m benchmarks.assets.semantics --names

`semantics_truth.csv` says by eye what the objects of the development assets and of `pybullet_data` are, a category of
the vocabulary (or several that are right, separated by `|`) or `other`, and whether a name within reach of the reader
(file, folder, nodes, materials) indicates it. Every object is annotated twice: as it is, and with all names removed.
Nothing of the table is known to the annotator.

`--names` annotates names of Google Scanned Objects (CC BY 4.0) in `semantics_names.csv`, with the longest edge of the
scan. The rest of the shape is made up so that it agrees with whatever the name says: the worst case, since no contrary
form is ever seen. `seen` rows were looked at while rules were made, the others were not.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from assetkit.annotate.annotator import UNKNOWN, Annotation, ObjectShape, Observation
from assetkit.annotate.domain import out_of_domain
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.name_reading import read_name
from assetkit.annotate.observe import observe
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.stage import Draft
from assetkit.taxonomy.tables import categories
from benchmarks.assets.truth_files import largest, roots

TABLE = Path(__file__).with_name("semantics_truth.csv")
NAMES = Path(__file__).with_name("semantics_names.csv")
OTHER = "other"


class Row(NamedTuple):
    """One object: its truth, whether names indicate it, annotations with and without names, why it is screened out."""

    path: str
    truth: str
    named: bool
    said: Annotation
    nameless: str
    outside: str


def rows(assets: Path, only: str = "") -> Iterator[Row]:
    """The rows of the table, the largest object of each file; files that intake refuses are left out."""
    annotator = EmbeddedAnnotator()
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            seen = observed(roots(assets)[row["root"]] / row["path"]) if only in row["path"] else None
            if seen is not None:
                blind = replace(seen, file="part", folders=(), nodes=(), materials=(), titles=())
                said, nameless = annotator.annotate(seen), annotator.annotate(blind).category
                yield Row(row["path"], row["truth"], row["named"] == "yes", said, nameless, out_of_domain(seen, said))


def observed(path: Path) -> Observation | None:
    """What the annotator is shown of the largest object of a file."""
    item = largest(path, Options())
    canonical = canonicalize(item, path.name, Options()).value if item else None
    return observe(Draft("part", path.name, item, canonicalize=canonical)) if item and canonical else None


def ends_of_names() -> dict[str, Counter[str]]:
    """How many names are read rightly, not at all and wrongly, by whether they were seen before."""
    ends: dict[str, Counter[str]] = {"yes": Counter(), "no": Counter()}
    with NAMES.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            seen = Observation(row["name"], (), (), (), (), _agreeing(row["name"], float(row["largest_m"])))
            said = EmbeddedAnnotator().annotate(seen)
            ends[row["seen"]][_end(Row(row["name"], row["truth"], True, said, UNKNOWN, ""))] += 1
    return ends


def _agreeing(name: str, largest_m: float) -> ObjectShape:
    """A shape of this longest edge that supports the category of the name."""
    category = categories().get(read_name(name).category or "")
    if category is None:
        return ObjectShape((largest_m, largest_m, largest_m), None, None)
    small, middle = (min(math.sqrt(low * high), largest_m) for low, high in category.extents_m[:2])
    fill = sum(category.fill) / 2.0 if category.fill else None
    return ObjectShape((min(small, middle), max(small, middle), largest_m), fill, 0.5)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path, nargs="?")
    parser.add_argument("--only", default="")
    parser.add_argument("--names", action="store_true")
    arguments = parser.parse_args()
    if arguments.names:
        for seen, ends in ends_of_names().items():
            counts = ", ".join(f"{count} {end}" for end, count in sorted(ends.items()))
            print(f"{sum(ends.values())} names {'seen before' if seen == 'yes' else 'not seen before'}: {counts}")
        return
    if arguments.assets is None:
        parser.error("the folder of the assets is missing")
    table: list[Row] = []
    for row in rows(arguments.assets, arguments.only):
        table.append(row)
        mark = "" if _end(row) != "wrong" else "WRONG"
        told = "named" if row.named else "-"
        why = row.outside or (row.said.reason if mark or row.said.category == UNKNOWN else "")
        print(
            f"{row.path:70} {row.truth:16} {told:6}{row.said.category:16} {row.said.score:.2f} {mark:6}{why}",
            flush=True,
        )
    summary(table)


def summary(table: list[Row]) -> None:
    """Counts over all rows."""
    told = [r for r in table if r.named]
    untold = [r for r in table if not r.named]
    for title, group in (("named after a category", told), ("not named, or something else", untold)):
        ends = Counter(_end(r) for r in group)
        print(f"{title}: {len(group)}; {', '.join(f'{count} {end}' for end, count in sorted(ends.items()))}")
    print(f"screened as out of domain: {sum(bool(r.outside) for r in table)}")
    print(f"names taken away: {sum(r.nameless != UNKNOWN for r in table)} of {len(table)} said to be something")


def _end(row: Row) -> str:
    return (
        "right" if row.said.category in row.truth.split("|") else UNKNOWN if row.said.category == UNKNOWN else "wrong"
    )


if __name__ == "__main__":
    main()
