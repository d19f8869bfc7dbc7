"""Speed of a large catalog: `python -m benchmarks.library.catalog --rows 100000 [--library LIBRARY]`.

Rows are made from real records, those of LIBRARY or the one of the tests: another id, name, category, size, mass,
colours, licence and a shifted shape descriptor, drawn from a seed; anchors, joints, parts and affordances stay. Prints
how long the catalog takes to fill, and for each request its rows and, in milliseconds, the medians of processor and
wall time and the least wall time of several runs, without the start of the program.
"""

from __future__ import annotations

import argparse
import json
import sqlite3
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from random import Random
from statistics import median

from assetkit.library import catalog
from assetkit.library.catalog import Selection
from assetkit.library.catalog.neighbours import update_neighbours
from assetkit.library.catalog.store import insert_record, writable
from assetkit.library.search.parse_query import parse_query
from assetkit.taxonomy.tables import categories
from schemas.asset import AssetRecord

SAMPLE = Path(__file__).parents[2] / "tests" / "data" / "record.json"
RUNS = 9
SHOWN = 20
SEED = 20261127
UNKNOWN_SHARE = 0.3  # of categories, as in libraries of files with poor names
SHIFT = 0.1  # of the figures of a descriptor: several times the distance of neighbours
COLOURS = ("red", "blue", "green", "white", "black", "brown", "grey", "yellow", "orange", "pink", "purple")
LICENCES = ("CC0-1.0", "CC-BY-4.0", "CC-BY-SA-4.0", "unknown")
REQUESTS = (
    "mug",
    "red mug",
    "red mug I can pour from",
    "mug with a handle under 12 cm",
    "drinkware not red",
    "wooden tray under 40 cm",
    "receptacle at least 200 g",
    "cabinet to put things into",
    "small blue bowl",
    "item_04217",
    "something blue between 5 and 20 cm",
    "red unicorn",
)
SELECTIONS = {
    "first 1000": Selection(limit=1000),
    "page at 90,000": Selection(limit=1000, offset=90000),
    "category mug": Selection(category="mug", limit=1000),
    "licence CC-BY": Selection(license="cc-by", limit=1000),
    "mass and size": Selection(min_mass_kg=0.2, max_mass_kg=0.4, max_size_m=0.2, limit=1000),
    "prismatic joint": Selection(joint_type="prismatic", limit=1000),
    "volume anchor of 0.1 l": Selection(anchor="volume", min_capacity_m3=1e-4, limit=1000),
    "name (one row)": Selection(name="item_04217", limit=1000),
}


def main() -> None:
    """Prints a table row per request."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--library", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        fill(out, arguments.rows, arguments.library)
        size_mib = (out / catalog.CATALOG).stat().st_size / 2**20
        print(f"{arguments.rows} rows, {size_mib:.0f} MiB")
        medians = [
            timed(f"search '{request}'", lambda request=request: _searched(out, request)) for request in REQUESTS
        ]
        print(f"search: median of medians {1e3 * median(medians):.1f} ms, worst {1e3 * max(medians):.1f} ms")
        medians = [timed(f"list {name}", lambda s=s: len(catalog.listing(out, s))) for name, s in SELECTIONS.items()]
        print(f"list: median of medians {1e3 * median(medians):.1f} ms, worst {1e3 * max(medians):.1f} ms")
        timed("stats", lambda: len(catalog.collection(out)))


def fill(out: Path, rows: int, library: Path | None) -> None:
    """A catalog of `rows` synthetic records in `out`; prints its seconds."""
    sources = [record for _, record in catalog.records(library)] if library else [_sample()]
    catalog.rebuild(out)
    digests: set[str] = set()
    started = time.process_time()
    with closing(writable(out)) as db:
        db.execute("BEGIN")
        for number, record in enumerate(synthetic(sources, rows)):
            insert_record(db, record, f"{number:064x}", digests)
        filled = time.process_time()
        update_neighbours(db, digests)
        db.execute("COMMIT")
        pairs = _pairs(db)
    ended = time.process_time()
    print(f"from {len(sources)} records, processor time: {filled - started:.1f} s for rows, then")
    print(f"{ended - filled:.1f} s for neighbours of {len(digests)} descriptors, {pairs} pairs to compare")


def _pairs(db: sqlite3.Connection) -> int:
    sql = "SELECT count(DISTINCT min(digest, other) || max(digest, other)) FROM neighbours"
    return int(db.execute(sql).fetchone()[0])


def _sample() -> AssetRecord:
    return AssetRecord.model_validate(json.loads(SAMPLE.read_text()))


def synthetic(sources: list[AssetRecord], rows: int) -> Iterator[AssetRecord]:
    """Variations of real records, equal for equal arguments."""
    draw = Random(SEED)
    known = list(categories().values())
    for number in range(rows):
        record = draw.choice(sources)
        category = None if draw.random() < UNKNOWN_SHARE else draw.choice(known)
        colours = {colour: draw.uniform(0.1, 0.6) for colour in draw.sample(COLOURS, 2)}
        factor = draw.uniform(0.3, 3.0)
        semantics, geometry, physics = record.semantics, record.geometry, record.physics
        name = " ".join([*colours, draw.choice([category.id, *category.aliases]) if category else "object"])
        extent = geometry.extent_m.model_copy(update={"value": tuple(factor * e for e in geometry.extent_m.value)})
        mass = physics.mass_kg.model_copy(update={"value": factor**3 * physics.mass_kg.value})
        stated = semantics.category.model_copy(
            update={"value": category.id, "confidence": draw.uniform(0.5, 1.0)}
            if category
            else {"value": "unknown", "confidence": 0.0}
        )
        family = semantics.family.model_copy(update={"value": category.family if category else "unknown"})
        licence = record.source.license.model_copy(update={"value": draw.choice(LICENCES)})
        shape = geometry.shape
        if shape is not None:
            shifted = [round(v + draw.uniform(-SHIFT, SHIFT), 5) for v in (*shape.second_moments, *shape.third_moments)]
            spread = draw.uniform(1.0 - SHIFT, 1.0 + SHIFT)
            shape = shape.model_copy(
                update={
                    "second_moments": tuple(shifted[:3]),
                    "third_moments": tuple(shifted[3:]),
                    "distances": tuple(round(spread * d, 5) for d in shape.distances),
                }
            )
        yield record.model_copy(
            update={
                "asset_id": f"item_{number:05d}",
                "semantics": semantics.model_copy(update={"name": name, "category": stated, "family": family}),
                "geometry": geometry.model_copy(update={"extent_m": extent, "shape": shape}),
                "physics": physics.model_copy(update={"mass_kg": mass}),
                "appearance": record.appearance.model_copy(update={"colours": colours}),
                "source": record.source.model_copy(update={"license": licence}),
            }
        )


def _searched(out: Path, request: str) -> int:
    return catalog.search_catalog(out, parse_query(request), SHOWN).total


def timed(name: str, request: Callable[[], int]) -> float:
    """Prints how many rows a request has, the medians of processor and wall time of `RUNS` runs and the least wall
    time; returns the median of processor time.
    """
    wall: list[float] = []
    processor: list[float] = []
    count = 0
    for _ in range(RUNS):
        started, at = time.perf_counter(), time.process_time()
        count = request()
        wall.append(time.perf_counter() - started)
        processor.append(time.process_time() - at)
    figures = (median(processor), median(wall), min(wall))
    print(f"| {name} | {count} | {' | '.join(f'{1e3 * figure:.1f}' for figure in figures)} |", flush=True)
    return median(processor)


if __name__ == "__main__":
    main()
