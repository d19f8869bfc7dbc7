"""Rows of the catalog: each filter leaves what it says, all of them hold at once, and counts add up."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from assetkit.library import catalog
from assetkit.library.catalog import Selection

SAMPLE = Path(__file__).parents[2] / "data" / "record.json"
ROWS = [  # name, outcome, category, roles, format, licence
    ("blue_mug", "accepted", "mug", ("receptacle", "manipulated"), "glb", "CC-BY-4.0"),
    ("red_mug", "review", "mug", ("manipulated",), "obj", "CC0-1.0"),
    ("tray", "accepted", "tray", ("receptacle", "support"), "glb", "unknown"),
    ("o'brien_tray", "repaired", "tray", (), "stl", "cc-by-sa-3.0"),
]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("library")
    for name, outcome, category, roles, source_format, license_ in ROWS:
        record = json.loads(SAMPLE.read_text()) | {"asset_id": name, "outcome": outcome}
        record["semantics"]["category"]["value"] = category
        stated = {"source": "declared", "method": "test", "confidence": 1.0}
        record["semantics"]["roles"] = [{"value": role, **stated} for role in roles]
        record["source"] |= {"format": source_format, "license": {"value": license_, **stated}}
        (out / name).mkdir()
        (out / name / "record.json").write_text(json.dumps(record))
    catalog.rebuild(out)
    return out


@pytest.mark.parametrize(
    ("chosen", "names"),
    [
        (Selection(), ["blue_mug", "o'brien_tray", "red_mug", "tray"]),
        (Selection(outcome="accepted"), ["blue_mug", "tray"]),
        (Selection(category="mug"), ["blue_mug", "red_mug"]),
        (Selection(role="receptacle"), ["blue_mug", "tray"]),
        (Selection(role="recept"), []),
        (Selection(role="manipulated", outcome="review"), ["red_mug"]),
        (Selection(format="stl"), ["o'brien_tray"]),
        (Selection(license="cc-by"), ["blue_mug", "o'brien_tray"]),
        (Selection(name="o'b"), ["o'brien_tray"]),
        (Selection(name="%"), []),
        (Selection(limit=2, offset=1), ["o'brien_tray", "red_mug"]),
    ],
)
def test_filters_leave_what_they_say(library: Path, chosen: Selection, names: list[str]):
    assert [row["asset_id"] for row in catalog.listing(library, chosen)] == names


def test_counts_add_up_and_an_asset_counts_in_each_role(library: Path):
    assert catalog.counts(library, "outcome") == {"accepted": 2, "repaired": 1, "review": 1}
    assert catalog.counts(library, "category") == {"mug": 2, "tray": 2}
    assert catalog.counts(library, "roles") == {"manipulated": 2, "receptacle": 2, "": 1, "support": 1}
