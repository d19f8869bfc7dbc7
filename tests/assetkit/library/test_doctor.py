"""Each damage that a crash can leave in a library is named; what is safe is repaired, and then nothing is left."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from assetkit.batch.ownership import OWNERS
from assetkit.library import catalog
from assetkit.library.doctor import examine
from jobs.cache import file_sha256
from jobs.lock import FolderInUse, exclusive

RECORD_SAMPLE = Path(__file__).parents[2] / "data" / "record.json"


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """Two packages with a file each, their notes of ownership and the catalog."""
    out = tmp_path / "library"
    for name in ("mug", "bowl"):
        (out / name / "usd").mkdir(parents=True)
        layer = out / name / "usd" / f"{name}.usda"
        layer.write_text(f"#usda 1.0\n# {name}\n")
        hashes = {layer.relative_to(out / name).as_posix(): file_sha256(layer)}
        record = json.loads(RECORD_SAMPLE.read_text()) | {"asset_id": name, "hashes": hashes}
        (out / name / "record.json").write_text(json.dumps(record))
        (out / OWNERS).mkdir(parents=True, exist_ok=True)
        (out / OWNERS / name).write_text(f"/sources/{name}.obj")
    catalog.rebuild(out)
    return out


def touch(name: str) -> Callable[[Path], object]:
    return lambda out: (out / name).write_text("half")


def renamed(old: str, new: str) -> Callable[[Path], object]:
    return lambda out: (out / old).rename(out / new)


def folder(name: str) -> Callable[[Path], object]:
    return lambda out: (out / name / "deep").mkdir(parents=True)


SAFE = [
    (folder(".work"), "asset/library-leftover"),
    (folder(".report.new"), "asset/library-leftover"),
    (touch(".report.html"), "asset/library-leftover"),
    (touch(".catalog.sqlite"), "asset/library-leftover"),
    (touch(".duck.json.1234"), "asset/library-leftover"),
    (folder(".mug.old"), "asset/library-leftover"),
    (renamed("mug", ".mug.old"), "asset/library-interrupted"),
    (lambda out: (out / OWNERS / "gone").write_text("/sources/gone.obj"), "asset/library-owner-dangling"),
    (lambda out: (out / "catalog.sqlite").unlink(), "asset/library-catalog-stale"),
    (touch("catalog.sqlite"), "asset/library-catalog-stale"),
]
UNSAFE = [
    lambda out: (out / "mug" / "usd" / "mug.usda").write_text("cut"),
    lambda out: (out / "mug" / "usd" / "mug.usda").unlink(),
]


def test_a_whole_library_has_no_findings(library: Path):
    found = examine(library)
    assert (found.packages, found.findings, found.healthy) == (2, (), True)


@pytest.mark.parametrize(("damage", "code"), SAFE)
def test_what_is_safe_is_repaired_and_only_when_asked(library: Path, damage: Callable[[Path], object], code: str):
    damage(library)
    before = sorted(p.relative_to(library) for p in library.rglob("*"))
    looked = examine(library, repair=False)
    assert [each.code for each in looked.findings][:1] == [code]
    assert not looked.healthy
    assert sorted(p.relative_to(library) for p in library.rglob("*")) == before
    assert examine(library).healthy
    assert examine(library).findings == ()
    assert [str(row["asset_id"]) for row in catalog.listing(library)] == ["bowl", "mug"]


@pytest.mark.parametrize("damage", UNSAFE)
def test_a_damaged_package_is_named_and_left_alone(library: Path, damage: Callable[[Path], object]):
    damage(library)
    kept = {p: p.read_bytes() for p in library.rglob("*") if p.is_file()}
    for _ in range(2):
        found = examine(library)
        assert [(each.code, each.where.file) for each in found.findings] == [("asset/library-package-damaged", "mug")]
        assert not found.healthy
    assert {p: p.read_bytes() for p in library.rglob("*") if p.is_file()} == kept


def test_a_package_without_a_record_is_damaged_and_leaves_the_catalog(library: Path):
    (library / "mug" / "record.json").unlink()
    found = examine(library)
    assert [each.code for each in found.findings] == ["asset/library-package-damaged", "asset/library-catalog-stale"]
    assert found.repaired == (False, True)
    assert (library / "mug" / "usd" / "mug.usda").is_file()


def test_folders_of_people_and_a_batch_at_work_are_left_alone(library: Path):
    (library / "notes").mkdir()
    (library / "notes" / "todo.txt").write_text("buy milk")
    assert examine(library).findings == ()
    with exclusive(library), pytest.raises(FolderInUse):
        examine(library)
