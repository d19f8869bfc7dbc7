"""Folders that a hurried person or a failing logger writes: each gets a located answer, none a traceback."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from simgap.recording.read import read
from simgap.recording.reading import tables
from tests.support.bad_inputs.gap import (
    FREE,
    IMPACT,
    Writer,
    csv,
    events,
    file_in,
    flight,
    folder_of,
    pushes,
    scaled,
    spec_text,
    tossed,
)
from tests.support.measurements import codes


def spec(old: str, new: str) -> Writer:
    return tossed(spec=FREE.replace(old, new))


def instead(name: str, save: Callable[[Path], None]) -> Writer:
    """The first toss in another file."""

    def write(folder: Path) -> Path:
        tossed()(folder)
        (folder / "trajectories" / "t0.csv").unlink()
        save(folder / "trajectories" / name)
        return folder

    return write


def npz(change: Callable[[np.ndarray], Any]) -> Writer:
    return instead(
        "t0.npz", lambda path: np.savez(path, **{n: change(v) for n, v in flight(0).items()}, allow_pickle=True)
    )


def parquet(**changes: object) -> Writer:
    columns = {n: pa.array(v) for n, v in flight(0).items()} | changes
    return instead("t0.parquet", lambda path: pq.write_table(pa.table(columns), path))


def bomb(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", bytes(2_000_000))


def false_header(path: Path) -> None:
    text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999,), }".ljust(117) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text)


def aliases(levels: int) -> str:
    lines = ["l0: &l0 [1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"l{k}: &l{k} [{', '.join([f'*l{k - 1}'] * 8)}]" for k in range(1, levels)]
    return "\n".join([*lines, f"schema_version: *l{levels - 1}", ""])


CASES: dict[str, tuple[Writer, str]] = {
    "no sources": (spec("p: [px, py, pz]", "p: []"), "gap/invalid-value"),
    "two of three sources": (spec("p: [px, py, pz]", "p: [px, py]"), "gap/invalid-value"),
    "a vector in one column": (spec("p: [px, py, pz]", "p: px"), "gap/unreadable-table"),
    "a mass that is no number": (spec("mass_kg: 0.3", "mass_kg: .nan"), "gap/invalid-value"),
    "a kind that does not exist": (spec("free_body", "freebody"), "gap/invalid-value"),
    "both degrees and radians": (
        tossed(more="sensor_noise: {rotation_rad: 0.01, rotation_deg: 1}\n"),
        "gap/invalid-value",
    ),
    "two shapes": (spec("  mass_kg", "  mesh: a.obj\n  mass_kg"), "gap/invalid-value"),
    "an empty side of the split": (tossed(more="split: {train: [t0, t1], test: []}\n"), "gap/too-few-trials"),
    "a side channel that is absent": (tossed(more="aux: {temperature_C: heat}\n"), "gap/missing-column"),
    "a list": (spec_text("- a\n"), "gap/invalid-value"),
    "nothing": (spec_text(""), "gap/invalid-value"),
    "bytes": (spec_text(b"\x00\xff\xfe"), "gap/yaml-syntax"),
    "a key twice": (spec_text(FREE + "name: again\n"), "gap/yaml-syntax"),
    "deep nesting": (spec_text("a: " + "[" * 1000), "gap/yaml-syntax"),
    "many aliases": (spec_text(aliases(12)), "gap/invalid-value"),
    "an absolute path": (spec("box: {size_m: [0.1, 0.06, 0.04]}", "urdf: /etc/hostname"), "gap/path-escape"),
    "a path upward": (spec("box: {size_m: [0.1, 0.06, 0.04]}", "mesh: ../other/a.obj"), "gap/path-escape"),
    "an absent model": (spec("box: {size_m: [0.1, 0.06, 0.04]}", "package: mug"), "gap/missing-file"),
    "a folder as model": (spec("box: {size_m: [0.1, 0.06, 0.04]}", "urdf: trajectories"), "gap/unreadable-subject"),
    "a pickle": (instead("t0.npz", lambda p: np.savez(p, t=np.array([{}], dtype=object))), "gap/unreadable-table"),
    "an array of three axes": (npz(lambda v: np.zeros((5, 2, 2))), "gap/unreadable-table"),
    "a number for an array": (npz(lambda v: np.float64(3.0)), "gap/empty-trial"),
    "words in an archive": (npz(lambda v: np.array(["a"] * 60)), "gap/unreadable-table"),
    "a zip bomb": (instead("t0.npz", bomb), "gap/file-too-large"),
    "a header that lies": (instead("t0.npz", false_header), "gap/unreadable-table"),
    "words in parquet": (parquet(t=pa.array(["a"] * 60)), "gap/unreadable-table"),
    "nulls in parquet": (parquet(px=pa.nulls(60)), "gap/empty-trial"),
    "lists of differing length": (parquet(px=pa.array([[1.0] * (k % 3) for k in range(60)])), "gap/unreadable-table"),
    "a torn line": (file_in("t1.csv", csv(flight(1)) + "0.6,1\n"), "gap/unreadable-cells"),
    "a column twice": (file_in("t1.csv", csv(flight(1)).replace("py", "px", 1)), "gap/unreadable-table"),
    "words only": (file_in("t1.csv", ",".join(flight(1)) + "\n" + "a,b\n" * 9), "gap/unreadable-table"),
    "one stamp for all": (tossed(scaled("t", 0.0)), "gap/clock-restarts"),
    "absurd numbers": (tossed(scaled("px", 1e300)), "gap/empty-trial"),
    "events that share an id": (
        lambda folder: folder_of(
            folder, IMPACT.replace("columns:", "columns:\n  id: id"), {"e": events(0) | {"id": np.zeros(50)}}
        ),
        "gap/trial-id-twice",
    ),
    "three poses": (
        pushes(lambda t: t | {"pose": {n: v[[0, 1, 1]] for n, v in t["pose"].items()}}),
        "gap/unreadable-table",
    ),
    "a push that nobody recorded": (
        pushes(lambda t: t | {"pose": {n: v * np.nan for n, v in t["pose"].items()}}),
        "gap/empty-trial",
    ),
}


@pytest.mark.parametrize("case", sorted(CASES))
def test_odd_inputs_get_a_located_answer(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tables, "MAX_TABLE_BYTES", 1_000_000)  # So that a bomb can be small.
    write, code = CASES[case]
    found = {d.code: d for d in read(write(tmp_path)).diagnostics}
    assert code in found
    assert found[code].where.file
    assert str(tmp_path) not in " ".join(f"{d.headline} {d.where}" for d in found.values())


def test_decimal_commas_and_clock_stamps_are_numbers(tmp_path: Path):
    plain = read(tossed()(tmp_path / "a")).value
    comma = read(file_in("t0.csv", csv(flight(0)).replace(",", ";").replace(".", ","))(tmp_path / "b")).value
    stamps = pa.array((flight(0)["t"] * 1e9).round().astype(np.int64), type=pa.timestamp("ns"))
    clock = read(parquet(t=stamps)(tmp_path / "c")).value
    assert plain is not None
    for other in (comma, clock):
        assert other is not None
        np.testing.assert_allclose(other.trials[0].p, plain.trials[0].p, atol=1e-8)
        np.testing.assert_allclose(other.trials[0].t_s, plain.trials[0].t_s, atol=1e-8)


@pytest.mark.parametrize("kind", ["pipe", "folder", "loop"])
def test_a_specification_that_is_no_file_is_missing_at_once(kind: str, tmp_path: Path) -> None:
    spec = tmp_path / "measurement.yaml"
    if kind == "pipe":
        os.mkfifo(spec)
    elif kind == "folder":
        spec.mkdir()
    else:
        spec.symlink_to(spec.name)
    assert codes(tmp_path) == {"gap/missing-file"}


def test_a_directive_that_the_parser_does_not_know_is_a_finding(tmp_path: Path) -> None:
    (tmp_path / "measurement.yaml").write_text("%YAML 9.9\n---\nname: x\n")
    assert codes(tmp_path) == {"gap/yaml-syntax"}


def test_stamps_beyond_every_epoch_are_rows_without_a_number(tmp_path: Path) -> None:
    def late(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return columns | {"t": np.where(np.arange(len(columns["t"])) == 20, 1e308, columns["t"])}

    assert codes(tossed(late)(tmp_path)) == {"gap/non-finite-rows", "gap/dropped-frames"}
