"""Compares named parts found on mugs, bottles, chairs and objects without any with those that a person sees.

    python -m benchmarks.assets.parts ASSETS_DIR [--only TEXT] [--category names|stated] [--stripped]

`parts_truth.csv` says for objects of the development assets and of `pybullet_data`, standing with `up_axis` up, which
named parts a person sees and in which box (low and high in x, y and z, as shares of the object's own box). Labels under
`may` count neither as missed nor as wrong. A part is found when its label is right and its box covers at least half of
the union with the one seen. With `--stripped` nodes, meshes, materials and files have no names; with
`--category stated` the category is that of the table, else the one that names indicate.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.observe import observe
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.parts.find import find_parts
from assetkit.stage import Draft, Intake
from benchmarks.assets.truth_files import located, object_of
from geom.features.cavities import find_cavities
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, declared, default, inferred
from schemas.parts import Part

TABLE = Path(__file__).with_name("parts_truth.csv")
OVERLAP = 0.5


class Row(NamedTuple):
    """One object: true parts, those found, missed labels, wrong labels, all parts, and CPU seconds for them."""

    path: str
    asked: int
    found: int
    missed: list[str]
    wrong: list[str]
    parts: int
    seconds: float


def rows(assets: Path, *, only: str = "", stated: bool = False, stripped: bool = False) -> Iterator[Row]:
    """The rows of the table whose path holds `only`, the largest object of each file."""
    with TABLE.open(encoding="utf-8") as file:
        for truth in csv.DictReader(file):
            if only in truth["path"]:
                yield _row(truth, *located(assets, truth["path"]), stated=stated, stripped=stripped)


def _row(truth: dict[str, str], file: Path, root: Path, *, stated: bool, stripped: bool) -> Row:
    options = Options.model_validate({"up_axis": truth["up_axis"]})
    item = object_of(file, options, root)
    canonical = canonicalize(item, file.name, options).value
    assert canonical is not None, f"{file} is not refused"
    draft = Draft("it", file.name, item, canonicalize=canonical)
    if stripped:
        draft = stripped_of(draft)
    category = declared(truth["category"], "table") if stated else category_of(draft)
    meshes = draft.model.meshes_by_id
    cavities = find_cavities(canonical.solid)
    started = time.process_time()
    parts = find_parts(meshes, draft.model.materials, category, cavities=cavities).parts
    seconds = time.process_time() - started
    asked = _boxes(truth["parts"])
    return _judged(truth, asked, [p.value for p in parts], np.array(canonical.section.extent_m.value), seconds)


def _judged(
    truth: dict[str, str],
    asked: list[tuple[str, FloatArray]],
    parts: Sequence[Part],
    extent: FloatArray,
    seconds: float,
) -> Row:
    may, wrong, left = set(truth["may"].split()), [], list(asked)
    for part in sorted((p for p in parts if p.label.confidence > 0.0), key=lambda p: -p.label.confidence):
        low = np.array(part.low_m) / extent + [0.5, 0.5, 0.0]  # The origin is the middle of the bottom.
        high = np.array(part.high_m) / extent + [0.5, 0.5, 0.0]
        near = [(_overlap(low, high, box), i) for i, (label, box) in enumerate(left) if label == part.label.value]
        best, index = max(near, default=(0.0, -1))
        if best >= OVERLAP:
            del left[index]
        elif part.label.value not in may:
            wrong.append(f"{part.label.value} ({best:.2f})")
    missed = [label for label, _ in left]
    return Row(truth["path"], len(asked), len(asked) - len(left), missed, wrong, len(parts), seconds)


def _overlap(low: FloatArray, high: FloatArray, box: FloatArray) -> float:
    """Intersection over union of two boxes in shares of the object's box."""
    shared = np.prod(np.maximum(np.minimum(high, box[1]) - np.maximum(low, box[0]), 0.0))
    return float(shared / (np.prod(high - low) + np.prod(box[1] - box[0]) - shared))


def _boxes(text: str) -> list[tuple[str, FloatArray]]:
    entries = [entry.split() for entry in text.split(";") if entry.strip()]
    return [(words[0], np.array(words[1:], dtype=float).reshape(3, 2).T) for words in entries]


def category_of(draft: Draft) -> Evidence[str]:
    """The category that names indicate, as in the semantics stage."""
    annotation = EmbeddedAnnotator().annotate(observe(draft))
    return (
        inferred(annotation.category, annotation.method, annotation.score)
        if annotation.score
        else default(annotation.category)
    )


def stripped_of(draft: Draft) -> Draft:
    """The draft without a name in it."""
    model, canonical = draft.intake.model, draft.canonicalize
    assert canonical is not None
    meshes = tuple(replace(m, name=f"m{i}", source_path=f"/m{i}") for i, m in enumerate(canonical.meshes))
    bare = replace(model, metadata={}, materials=tuple(replace(m, name=f"x{i}") for i, m in enumerate(model.materials)))
    intake: Intake = replace(draft.intake, model=bare, folder="", folders=())
    return replace(draft, source_name="a.obj", intake=intake, canonicalize=replace(canonical, meshes=meshes))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--category", choices=("names", "stated"), default="names")
    parser.add_argument("--stripped", action="store_true")
    given = parser.parse_args()
    table = []
    for row in rows(given.assets, only=given.only, stated=given.category == "stated", stripped=given.stripped):
        table.append(row)
        notes = [*(f"missed {m}" for m in row.missed), *(f"wrong {w}" for w in row.wrong)]
        print(f"{row.path:80} {row.found:2}/{row.asked:<2} {row.parts:3} {row.seconds:5.2f} s  {'; '.join(notes)}")
    asked, found = sum(r.asked for r in table), sum(r.found for r in table)
    wrong = sum(len(r.wrong) for r in table)
    seconds = sorted(r.seconds for r in table)
    print(f"{len(table)} objects, {sum(r.asked > 0 for r in table)} with named parts")
    print(f"recall {found} of {asked} ({found / max(asked, 1):.0%})")
    print(f"precision {found} of {found + wrong} ({found / max(found + wrong, 1):.0%}), labels under `may` left out")
    print(f"CPU: median {seconds[len(seconds) // 2]:.2f} s, slowest {seconds[-1]:.2f} s an object")


if __name__ == "__main__":
    main()
