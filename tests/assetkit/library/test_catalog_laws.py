"""Laws of the catalog: an update equals a rebuild, a search by indexes equals one over all facts."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from random import Random

import pytest

from assetkit.library import catalog
from assetkit.library.catalog.migrations import MIGRATIONS
from assetkit.library.search.parse_query import parse_query
from assetkit.library.search.query import Criterion
from assetkit.library.search.search import SearchResult, search
from tests.support.library.record_library import random_record, write

# Every table of the catalog with its rows, without what may differ: keys, numbers of rows and stamps.
QUERIES = {
    "assets": "SELECT * FROM assets",
    "traits": "SELECT asset_id, field, value, confidence FROM traits JOIN assets USING (key)",
    "records": "SELECT asset_id, sha256, schema_version, facts FROM records JOIN assets USING (key)",
    "sources": "SELECT asset_id, position, path, sha256, bytes FROM sources JOIN assets USING (key)",
    "words": "SELECT asset_id, w.names, source_texts, aliases, others FROM words w JOIN assets ON w.rowid = key",
    "outcomes": "SELECT * FROM outcomes",
    "shapes": "SELECT asset_id, digest, scale_m, geometry FROM shapes JOIN assets USING (key)",
    "descriptors": "SELECT digest, vector FROM descriptors",
    "descriptor_boxes": "SELECT digest, low_1, high_5 FROM descriptor_boxes JOIN descriptors USING (number)",
    "neighbours": "SELECT * FROM neighbours",
}
DERIVED = {"stamps", "comparisons"}  # the state of files, and results of `near_duplicates`


def content(out: Path) -> dict[str, list[tuple[object, ...]]]:
    with closing(sqlite3.connect(out / catalog.CATALOG)) as db:
        rows = {table: db.execute(sql).fetchall() for table, sql in QUERIES.items()}
    rows["assets"] = [row[1:] for row in rows["assets"]]
    return {table: sorted(map(tuple, of_table), key=repr) for table, of_table in rows.items()}


def test_the_law_looks_at_every_table():
    with closing(sqlite3.connect(":memory:")) as db:
        for script in MIGRATIONS:
            db.executescript(script)
        sql = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE '%\\_%' ESCAPE '\\'"
        names = {name for (name,) in db.execute(sql)} | {"descriptor_boxes"}
    assert names == {*QUERIES, *DERIVED}


def report(out: Path, draw: Random) -> None:
    items = [
        {"source": f"{k}.obj", "outcome": draw.choice(("accepted", "rejected")), "codes": ["asset/no-faces"]}
        for k in range(draw.randrange(4))
    ]
    (out / "report.json").write_text(json.dumps({"items": items, "totals": {}}))


def edit(out: Path, draw: Random) -> None:
    """One change of a library, as a batch, a person or a crash makes it."""
    name = f"asset_{draw.randrange(6)}"
    match draw.randrange(8):
        case 0 | 1 | 2 | 3:
            write(out, random_record(draw, name))
        case 4:
            shutil.rmtree(out / name, ignore_errors=True)
        case 5:
            (out / name).mkdir(exist_ok=True)
            (out / name / "record.json").write_text(draw.choice(("", "{}", json.dumps({"asset_id": "other"}))))
        case 6:
            report(out, draw)
        case _:
            (out / "report.json").unlink(missing_ok=True)


@pytest.mark.parametrize("seed", range(12))
def test_an_update_leaves_what_a_rebuild_writes(seed: int, tmp_path: Path):
    draw = Random(seed)
    for _ in range(8):
        for _ in range(draw.randrange(4)):
            edit(tmp_path, draw)
        catalog.update(tmp_path)
        updated = content(tmp_path)
        catalog.rebuild(tmp_path)
        assert updated == content(tmp_path)


def test_an_update_writes_only_the_rows_of_what_has_changed(tmp_path: Path):
    draw = Random(1)
    for k in range(5):
        write(tmp_path, random_record(draw, f"asset_{k}"))
    assert catalog.update(tmp_path) == 5
    assert catalog.update(tmp_path) == 0
    text = (tmp_path / "asset_1" / "record.json").read_text()
    (tmp_path / "asset_1" / "record.json").write_text(text)  # Written anew with the same bytes.
    write(tmp_path, random_record(draw, "asset_3"))
    shutil.rmtree(tmp_path / "asset_4")
    assert catalog.update(tmp_path) == 2


def test_a_catalog_of_the_first_version_is_migrated_when_it_is_read(tmp_path: Path):
    write(tmp_path, random_record(Random(2), "asset_0"))
    with closing(sqlite3.connect(tmp_path / catalog.CATALOG)) as db:
        db.executescript(MIGRATIONS[0])
        db.execute("INSERT INTO assets (asset_id, outcome) VALUES ('gone', 'accepted')")
        db.commit()
    assert [row["asset_id"] for row in catalog.listing(tmp_path)] == ["asset_0"]
    migrated = content(tmp_path)
    catalog.rebuild(tmp_path)
    assert migrated == content(tmp_path)


REQUESTS = (
    "",
    "mug",
    "red mug",
    "mug I can pour from",
    "mug with a handle",
    "mug without a handle",
    "not red",
    "not a mug",
    "wooden bowl under 10 cm",
    "receptacle at least 200 g",
    "drinkware not under 8 cm",
    "small mug",
    "nice mug",
    "red unicorn",
    "candle",
    "чайник",
    "steel cabinet to put things into",
    "something to stand things on, not wooden",
    "thingamajig",
    "mug or bowl not to pour from",
    "lid",
)
FLAGS = (
    Criterion("--category mug", "category", ("mug",), is_kind=True, stated=True),
    Criterion("--category unknown", "category", ("unknown",), is_kind=True, stated=True),
    Criterion("--has volume", "anchor", ("volume",), stated=True),
    Criterion("not --has", "anchor", ("volume",), negated=True),
    Criterion("not --outcome", "outcome", ("accepted",), negated=True),
    Criterion("not --mass", "mass_kg", low=0.1, high=1.0, negated=True),
    Criterion("not candle", "text", ("candle", "can"), negated=True),
    Criterion("no lid to open", "task", ("open",), negated=True),
)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("library")
    draw = Random(20261127)
    for k in range(300):
        write(out, random_record(draw, f"asset_{draw.randrange(10**6):06d}_{k}"))
        if k % 50 == 49:  # Keys in another order than ids.
            catalog.update(out)
    return out


@pytest.mark.parametrize(
    "criteria",
    [*(tuple(parse_query(text)) for text in REQUESTS), *((flag,) for flag in FLAGS), FLAGS[2:5], FLAGS[5:]],
    ids=lambda criteria: " ".join(c.words for c in criteria) or "everything",
)
def test_a_search_by_indexes_equals_one_over_all_facts(criteria: tuple[Criterion, ...], library: Path):
    expected = search(catalog.facts(library), criteria, lambda criterion: catalog.find_text(library, criterion))
    for limit in (3, 1000):
        result = catalog.search_catalog(library, criteria, limit)
        assert shown(result) == shown(expected, limit)


def test_the_requests_of_the_law_have_hits_and_near_misses(library: Path):
    results = [catalog.search_catalog(library, tuple(parse_query(text)), 1000) for text in REQUESTS]
    assert sum(result.total > 5 for result in results) >= 10
    assert any(result.near_misses for result in results)
    assert any(result.unmatched for result in results)


def shown(result: SearchResult, limit: int = 1000) -> object:
    """Everything of a result; a text may be quoted around another of its matching words."""

    def hit(h):
        reasons = [(r.criterion, r.field, r.confidence, r.evidence) for r in (*h.matches, *h.misses)]
        return h.asset.asset_id, h.score, reasons

    return [hit(h) for h in result.hits[:limit]], [hit(h) for h in result.near_misses], result.unmatched, result.total
