"""How often the embedded annotator is right, silent and wrong.

    python -m benchmarks.semantics ASSETS_DIR [--only TEXT]

`semantics_truth.csv` says by eye what the objects of the development assets and of `pybullet_data` are, a category of
the vocabulary (or several that are right, separated by `|`) or `other`, and whether a name within reach of the reader
(file, folder, nodes, materials) tells it. Every object is asked about twice: as it is, and with all names taken away.
Nothing of the table is known to the annotator.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pybullet_data

from assetkit.annotate.annotator import UNKNOWN, Annotation, Observation
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.discover import discover
from assetkit.options import Options
from assetkit.stage import Draft
from assetkit.stages.canonicalize import canonicalize
from assetkit.stages.intake import take_in
from assetkit.stages.semantics import observe

TABLE = Path(__file__).with_name("semantics_truth.csv")
OTHER = "other"


class Row(NamedTuple):
    """One object: its truth, whether names tell it, what was said with names and without."""

    path: str
    truth: str
    named: bool
    said: Annotation
    nameless: str


def rows(assets: Path, only: str = "") -> Iterator[Row]:
    """The rows of the table, the largest object of each file; files that intake refuses are left out."""
    roots = {"dev": assets, "pybullet": Path(pybullet_data.getDataPath())}
    annotator = EmbeddedAnnotator()
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            seen = observed(roots[row["root"]] / row["path"]) if only in row["path"] else None
            if seen is not None:
                blind = replace(seen, file="part", folders=(), nodes=(), materials=(), titles=())
                said, nameless = annotator.annotate(seen), annotator.annotate(blind).category
                yield Row(row["path"], row["truth"], row["named"] == "yes", said, nameless)


def observed(path: Path) -> Observation | None:
    """What the annotator is shown of the largest object of a file."""
    taken = take_in(discover([path])[0], Options()).objects
    canonical = canonicalize(taken[0], path.name, Options()).value if taken else None
    return observe(Draft("part", path.name, taken[0], canonicalize=canonical)) if canonical else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    table: list[Row] = []
    for row in rows(arguments.assets, arguments.only):
        table.append(row)
        mark = "" if _end(row) != "wrong" else "WRONG"
        told = "named" if row.named else "-"
        why = row.said.reason if mark or row.said.category == UNKNOWN else ""
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
    print(f"names taken away: {sum(r.nameless != UNKNOWN for r in table)} of {len(table)} said to be something")


def _end(row: Row) -> str:
    return (
        "right" if row.said.category in row.truth.split("|") else UNKNOWN if row.said.category == UNKNOWN else "wrong"
    )


if __name__ == "__main__":
    main()
