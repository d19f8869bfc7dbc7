"""The comparison with obj2mjcf adds up: rows survive the file, ratios are paired, distances mean what they say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.assets.obj2mjcf.likeness import likeness
from benchmarks.assets.obj2mjcf.table import Row, read_rows, summary, write_rows
from benchmarks.assets.scale import Growth, slopes, varied
from geom.mesh.primitives import cube

ROW = Row(
    file="a/a.obj",
    triangles=12,
    ours_ended="accepted",
    ours_method="cuts",
    ours_cpu_s=2.0,
    ours_wall_s=1.0,
    ours_process_mb=90.0,
    ours_together_mb=100.0,
    ours_hulls=3,
    ours_p95=0.5,
    ours_mean=0.2,
    ours_largest=1.0,
    theirs_ended="ok",
    theirs_cpu_s=4.0,
    theirs_wall_s=5.0,
    theirs_process_mb=60.0,
    theirs_together_mb=50.0,
    theirs_hulls=4,
    theirs_p95=1.0,
    theirs_mean=0.4,
    theirs_largest=2.0,
)


def test_rows_survive_the_file(tmp_path: Path):
    write_rows([ROW], tmp_path)
    assert read_rows(tmp_path / "assets.csv") == [ROW]


def test_only_files_that_both_finish_are_compared_and_single_shapes_are_told_apart():
    rows = [
        ROW,
        replace(ROW, file="b/b.obj", ours_method="box", ours_cpu_s=12.0),
        replace(ROW, file="c/c.obj", theirs_ended="time-out"),
        replace(ROW, file="d/d.obj", ours_ended="rejected", ours_method="", ours_hulls=0),
    ]
    text = summary(rows)
    assert "4 files; compared 2." in text
    assert "all compared, 2 files: CPU ratio median 1.75 (min 0.50, max 3.00), not slower in 1" in text
    assert "both decomposed, 1 files: CPU ratio median 0.50" in text
    assert "did not finish (1): c/c.obj: time-out" in text
    assert "made no package (1): d/d.obj: rejected" in text


def test_distances_of_a_grown_cube_are_its_growth():
    points, triangles, _ = cube(2.0)
    exact = likeness([points], points, triangles)
    grown = likeness([points * 1.1], points, triangles)
    assert exact.hulls == 1
    assert exact.p95 < 0.1  # percent of the diagonal: the slit that the measure closes by growing parts
    size = 2.0 * np.sqrt(3.0)
    assert grown.mean == pytest.approx(100 * 0.1 / size, rel=0.05)  # faces move by 0.1, little more at the edges
    assert grown.largest == pytest.approx(100 * 0.1 * np.sqrt(3.0) / size, rel=0.05)  # the corners


def test_copies_differ_and_are_the_same_every_time():
    again = [varied(index)[0] for index in range(6)]
    assert all(np.array_equal(varied(index)[0], points) for index, points in enumerate(again))
    assert len({points.tobytes() for points in again}) == 6


def test_linear_cost_is_called_linear():
    rows = [Growth("ingest", n, 1, 3.0 + 0.5 * n, 0.0, 0.0, 0.0) for n in (10, 50, 100)]
    assert slopes(rows) == (
        "- ingest: 3.0 s + 500.0 ms an asset (least squares); the last step costs 1.00 times the average"
    )
