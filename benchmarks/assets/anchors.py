"""Compares surfaces and volumes found on furniture, vessels and objects without any with what a person sees.

    python -m benchmarks.assets.anchors ASSETS_DIR [--only TEXT] [--proposed]

`anchors_truth.csv` says for objects of the development assets and of `pybullet_data`, standing with `up_axis` up, at
which heights (as a share of the object's own) a person sees a surface to stand on, or the floor of something to put
things into. Heights listed as `may` count neither as missed nor as wrong. The pipeline does not get the table.
Anchors count as released: proposed from geometry and held up by probes on the colliders in simulation; with
`--proposed` simulation and colliders are left out.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, cast

from assetkit.affordances.anchor_trials import verify_anchors
from assetkit.affordances.anchors import propose_anchors
from assetkit.colliders.choose import choose_colliders
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options, UpAxisName
from benchmarks.assets.truth_files import located, object_of
from geom.features.cavities import find_cavities
from schemas.anchors import Anchor
from sim.bullet.simulator import BulletSimulator

TABLE = Path(__file__).with_name("anchors_truth.csv")
SAME_HEIGHT = 0.04  # of the object's height


class Row(NamedTuple):
    """One object: heights missed, of those of the table, and heights that are wrong, of those found."""

    path: str
    asked: int
    found: int
    missed: list[str]
    wrong: list[str]
    refuted: int
    seconds: float


def rows(assets: Path, *, only: str = "", proposed: bool = False) -> Iterator[Row]:
    """The rows of the table whose path holds `only`, the largest object of each file."""
    with TABLE.open(encoding="utf-8") as file, BulletSimulator() as simulator:
        for truth in csv.DictReader(file):
            if only in truth["path"]:
                yield _row(truth, *located(assets, truth["path"]), None if proposed else simulator)


def _row(truth: dict[str, str], file: Path, root: Path, simulator: BulletSimulator | None) -> Row:
    options = Options(up_axis=cast(UpAxisName, truth["up_axis"]))  # Options checks the word
    canonical = canonicalize(object_of(file, options, root), file.name, options).value
    assert canonical is not None, f"{file} is not refused"
    started = time.perf_counter()
    anchors: Sequence[Anchor] = propose_anchors(canonical.solid, find_cavities(canonical.solid))
    seconds, refuted = time.perf_counter() - started, 0
    if simulator is not None:
        with tempfile.TemporaryDirectory() as folder:
            shapes = choose_colliders(canonical.solid, Path(folder)).shapes
        started = time.perf_counter()
        tried = verify_anchors(anchors, shapes, simulator)
        seconds += time.perf_counter() - started
        anchors, refuted = [a.value for a in tried.anchors], len(tried.diagnostics)
    height_m = canonical.section.extent_m.value[2]
    missed, wrong, asked = [], [], 0
    for kind, column in (("surface", "surfaces"), ("volume", "volumes")):
        must, may = _heights(truth[column]), _heights(truth[f"{column}_may"])
        asked += len(must)
        for found in sorted(a.position_m[2] / height_m for a in anchors if a.kind == kind):
            near = [seen for seen in (must, may) if any(abs(h - found) <= SAME_HEIGHT for h in seen)]
            if near:
                near[0].remove(min(near[0], key=lambda h: abs(h - found)))
            else:
                wrong.append(f"{kind} {found:.2f}")
        missed += [f"{kind} {h:.2f}" for h in must]
    return Row(truth["path"], asked, len(anchors), missed, wrong, refuted, seconds)


def _heights(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--proposed", action="store_true")
    arguments = parser.parse_args()
    table = []
    for row in rows(arguments.assets, only=arguments.only, proposed=arguments.proposed):
        table.append(row)
        notes = [*(f"missed {m}" for m in row.missed), *(f"wrong {w}" for w in row.wrong)]
        notes += [f"{row.refuted} refuted"] if row.refuted else []
        print(f"{row.path:90} {row.asked - len(row.missed):2}/{row.asked:<2} {row.seconds:5.2f} s  {'; '.join(notes)}")
    asked, found = sum(r.asked for r in table), sum(r.found for r in table)
    missed, wrong = sum(len(r.missed) for r in table), sum(len(r.wrong) for r in table)
    seconds = sorted(r.seconds for r in table)
    print(f"{len(table)} objects, {sum(r.asked > 0 for r in table)} with anchors")
    print(f"found {asked - missed} of {asked} ({(asked - missed) / max(asked, 1):.0%})")
    print(f"wrong {wrong} of {found} ({wrong / max(found, 1):.0%})")
    print(f"refuted in simulation {sum(r.refuted for r in table)}")
    print(f"median {seconds[len(seconds) // 2]:.2f} s, slowest {seconds[-1]:.2f} s an object")


if __name__ == "__main__":
    main()
