"""`mana assets gc`: only what nothing can use goes, by kind and size; a killed one leaves a whole library."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from assetkit.batch.result_store import StoredResult, read_stored
from assetkit.library.doctor import examine
from assetkit.pipeline import StoredNotes
from cli.main import app
from jobs.lock import exclusive
from jobs.versions import versions_key
from schemas.asset import AssetRecord
from schemas.files import array_files
from tests.assetkit.batch.small_batch import SmallBatch, plain_texts, small_batch

OTHER = "stage results of other versions"


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> SmallBatch:
    """A library of three packages that a batch has made."""
    batch = small_batch(tmp_path_factory.mktemp("gc"), plain_texts(3), "a_cell_before_gc")
    assert batch.run()["accepted"] == 3
    return batch


@pytest.fixture
def batch(first: SmallBatch, tmp_path: Path) -> SmallBatch:
    """A copy of it; its sources stay where they were."""
    subprocess.run(["cp", "-a", str(first.out), str(tmp_path / "out")], check=True)
    return first


def gc(library: Path, *flags: str) -> tuple[int, dict[str, tuple[int, int]]]:
    """Exit code, and files and bytes by kind."""
    result = CliRunner().invoke(app, ["assets", "gc", str(library), "--json", *flags], catch_exceptions=False)
    answer: dict[str, Any] = json.loads(result.output)
    kinds = {each["kind"]: (each["files"], each["size_bytes"]) for each in answer["kinds"]}
    assert answer["size_bytes"] == sum(size for _, size in kinds.values())
    return result.exit_code, kinds


def stage_result(library: Path, key: str, versions: str, size: int = 100) -> list[Path]:
    """A stored value and its note, as the pipeline writes them."""
    folder = library / ".cache" / "stages" / "physics" / key[:2]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{key}.npz").write_bytes(bytes(size))
    array_files.save(StoredNotes((), (), False, versions), StoredNotes, folder / f"{key}.note.npz")
    return [folder / f"{key}.npz", folder / f"{key}.note.npz"]


def snapshot(library: Path) -> dict[str, bytes]:
    return {str(p.relative_to(library)): p.read_bytes() for p in sorted(library.rglob("*")) if p.is_file()}


def test_what_is_in_use_stays_and_the_next_ingest_makes_nothing_anew(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    useful = stage_result(library, "ab" * 32, versions_key())
    answers = library / ".cache" / "answers" / "cd" / "cd.json"
    answers.parent.mkdir(parents=True)
    answers.write_text("{}")
    (library / "decisions.jsonl").write_text("")
    before = snapshot(library)
    assert gc(library) == (0, {})
    assert snapshot(library) == before
    assert all(path.exists() for path in useful)
    moved = SmallBatch(tmp_path, batch.name)
    argv = [*batch.argv[:2], str(batch.place / "in"), str(library)]
    driver = subprocess.run(argv, env=batch.environment, capture_output=True, text=True, check=True)
    assert json.loads(driver.stdout)["cached"] == 3
    moved.require_sound()


def test_results_of_other_versions_go_and_are_measured(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    files = stage_result(library, "ab" * 32, "another version", 1000) + stage_result(library, "cd" * 32, "", 10)
    size = sum(path.stat().st_size for path in files)
    note = next((library / ".cache" / "items").glob("*.json"))
    old = StoredResult.model_validate_json(note.read_bytes()).model_copy(update={"versions": "another version"})
    note.write_text(old.model_dump_json())
    expected = {OTHER: (4, size), "stored items of other versions": (1, note.stat().st_size)}
    before = snapshot(library)
    assert gc(library, "--dry-run") == (0, expected)
    assert snapshot(library) == before
    assert gc(library) == (0, expected)
    assert gc(library) == (0, {})
    assert not any(path.exists() for path in [*files, note])
    assert examine(library, repair=False).healthy


def test_partial_files_replaced_packages_and_notes_on_absent_packages_go(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    value, _ = stage_result(library, "ab" * 32, versions_key())
    value.unlink()  # half of a result
    (library / ".work" / "deep").mkdir(parents=True)
    (library / ".work" / "deep" / "mesh.obj").write_text("v 0 0 0")
    (library / ".part_0.old").mkdir()
    (library / ".part_0.old" / "record.json").write_text("{}")
    (library / ".cache" / "items" / ".note.json.4711").write_text("half")
    (library / "part_2").rename(tmp_path / "elsewhere")
    _, kinds = gc(library)
    assert {kind: files for kind, (files, _) in kinds.items()} == {
        "partial files and folders": 3,
        "replaced packages": 1,
        "stored items of packages that are gone or newer": 1,
        "notes on packages that are gone": 2,
    }
    assert sorted(p.name for p in library.glob("*/record.json")) == ["record.json"] * 2
    assert gc(library) == (0, {})


def test_the_only_copy_of_a_package_is_no_garbage(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    (library / "part_1").rename(library / ".part_1.old")
    gc(library)
    assert (library / ".part_1.old" / "record.json").is_file()
    assert [f.code for f in examine(library).findings if f.code == "asset/library-interrupted"]
    assert (library / "part_1" / "record.json").is_file()


def test_all_takes_the_stage_results_that_no_record_names(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    record = AssetRecord.model_validate_json((library / "part_0" / "record.json").read_bytes())
    named = next(entry.key for entry in record.history if entry.key)
    stay = stage_result(library, named + "0" * 48, versions_key())
    go = stage_result(library, "ef" * 32, versions_key())
    assert gc(library) == (0, {})
    assert list(gc(library, "--all")[1]) == ["stage results that no record names"]
    assert [path.exists() for path in (*stay, *go)] == [True, True, False, False]


def test_nothing_goes_while_a_batch_is_at_work(batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    (library / ".work" / "deep").mkdir(parents=True)
    command = [sys.executable, "-m", "cli.main", "assets", "gc", str(library)]
    with exclusive(library):
        answer = subprocess.run(command, capture_output=True, text=True)
    assert answer.returncode == 2
    assert "is in use by process" in answer.stderr
    assert (library / ".work" / "deep").is_dir()


KILLED = """
import os, signal, sys
from pathlib import Path
from assetkit.library.garbage import collect_garbage
left = int(sys.argv[2])
def removed(_):
    global left
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
collect_garbage(Path(sys.argv[1]), removed=removed)
"""


@pytest.mark.parametrize("after", [1, 4, 7])
def test_killed_at_any_removal_it_leaves_a_whole_library(after: int, batch: SmallBatch, tmp_path: Path) -> None:
    library = tmp_path / "out"
    for key in ("ab", "cd", "ef"):
        stage_result(library, key * 32, "another version")
    (library / ".work" / "deep").mkdir(parents=True)
    (library / ".part_0.old" / "usd").mkdir(parents=True)
    packages = {name: data for name, data in snapshot(library).items() if name.startswith("part_")}
    stored = sorted((library / ".cache" / "items").glob("*.json"))
    killed = subprocess.run([sys.executable, "-c", KILLED, str(library), str(after)])
    assert killed.returncode == -signal.SIGKILL
    assert {name: data for name, data in snapshot(library).items() if name.startswith("part_")} == packages
    assert len(stored) == 3
    assert all(read_stored(note) is not None for note in stored)
    assert gc(library)[1]
    assert gc(library) == (0, {})
    assert examine(library, repair=False).findings == ()
