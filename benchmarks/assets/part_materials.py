"""Compares the materials of parts with those that a person sees.

    python -m benchmarks.assets.part_materials ASSETS_DIR [--only TEXT] [--stripped] [--category names|stated]

`part_materials_truth.csv` names regions of development assets and of `pybullet_data` and the classes that the eye
admits there, `?` where it cannot decide. A region is `all`, a `mesh` or render `material` by name, or the triangles
whose middle lies in a `box` (low and high in x, y and z as shares of the object's box). The material of most
of its area, by the smallest part there that has a material, else by the whole, is right, wrong or `unknown`. With
`--stripped` nodes, meshes, materials and files have no names; with `--category stated` the category is that of the
table.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from assetkit.geometry.canonical_model import canonicalize
from assetkit.materials.normalize import normalize
from assetkit.materials.part_materials import face_materials, part_materials
from assetkit.options import Options
from assetkit.parts.find import find_parts
from assetkit.stage import Canonical, Draft
from benchmarks.assets.parts import category_of, stripped_of
from benchmarks.assets.truth_files import located, object_of
from geom.features.cavities import find_cavities
from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray, IntArray
from schemas.evidence import Evidence, declared
from schemas.model import Mesh

TABLE = Path(__file__).with_name("part_materials_truth.csv")
UNKNOWN, UNSEEN = "unknown", "?"


class Row(NamedTuple):
    """One region: what the eye admits, what is said with its evidence."""

    path: str
    region: str
    truth: str
    said: Evidence[str]


def rows(assets: Path, *, only: str = "", stated: bool = False, stripped: bool = False) -> Iterator[tuple[Row, float]]:
    """Each region of the table whose path holds `only`, and CPU seconds spent on its object (0 after the first)."""
    with TABLE.open(encoding="utf-8") as file:
        table = [row for row in csv.DictReader(file) if only in row["path"]]
    for (path, up_axis, category), group in itertools.groupby(
        table, lambda r: (r["path"], r["up_axis"], r["category"])
    ):
        draft = canonical_draft(*located(assets, path), up_axis)
        truth_meshes, truth_materials = draft.model.meshes, [m.name for m in draft.model.materials]
        if stripped:
            bare = stripped_of(draft)
            draft = replace(bare, appearance=normalize(bare.intake.model).value)
        named = declared(category, "table") if stated and category else category_of(draft)
        meshes = draft.model.meshes_by_id
        cavities = find_cavities(draft[Canonical].solid)
        found = find_parts(meshes, draft.model.materials, named, cavities=cavities).parts
        started = time.process_time()
        parts, whole = part_materials(meshes, draft.model, found, named, draft.source_name, draft.intake.folders)
        seconds = time.process_time() - started
        evidence, of_face = face_materials(meshes, parts, whole)
        chosen = np.concatenate(of_face)
        area = np.concatenate([triangle_areas(m.points[m.triangles]) for m in meshes.values()])
        for row in group:
            inside = region_mask(row["region"], truth_meshes, truth_materials)
            assert inside.any(), f"{path}: nothing is in {row['region']}"
            most = int(np.bincount(chosen[inside], area[inside], len(evidence)).argmax())
            yield Row(path, row["region"], row["material"], evidence[most]), seconds
            seconds = 0.0


def canonical_draft(file: Path, root: Path, up_axis: str) -> Draft:
    """The object of a file as far as its appearance."""
    options = Options.model_validate({"up_axis": up_axis})
    item = object_of(file, options, root)
    canonical = canonicalize(item, file.name, options).value
    assert canonical is not None, f"{file} is not refused"
    return Draft("it", file.name, item, canonicalize=canonical, appearance=normalize(item.model).value)


def region_mask(text: str, meshes: tuple[Mesh, ...], materials: list[str]) -> IntArray:
    """(m,) True at the triangles of the region, counted through all meshes."""
    kind, _, rest = text.partition(" ")
    if kind in ("mesh", "material"):
        of = [m.name if kind == "mesh" else "" if m.material is None else materials[m.material] for m in meshes]
        return np.repeat([name == rest for name in of], [len(m.triangles) for m in meshes])
    corners = np.concatenate([m.points[m.triangles] for m in meshes])
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    share: FloatArray = (corners.mean(axis=1) - low) / (high - low)
    box = np.array(rest.split() or [0, 1] * 3, dtype=float).reshape(3, 2)
    return np.all((share >= box[:, 0]) & (share <= box[:, 1]), axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--category", choices=("names", "stated"), default="names")
    parser.add_argument("--stripped", action="store_true")
    given = parser.parse_args()
    table: list[Row] = []
    seconds: list[float] = []
    for row, spent in rows(given.assets, only=given.only, stated=given.category == "stated", stripped=given.stripped):
        table.append(row)
        seconds += [spent] if spent else []
        print(f"{_verdict(row):8} {row.said.value:9} {row.said.confidence:4.2f} {row.truth:26} {row.path} {row.region}")
        print(f"{'':24}{row.said.method}")
    asked = [row for row in table if row.truth != UNSEEN]
    counts = Counter(_verdict(row) for row in asked)
    said = counts["right"] + counts["wrong"]
    print(f"{len(asked)} regions of {len({r.path for r in asked})} objects; confusion of those that are wrong:")
    for (truth, value), count in Counter((r.truth, r.said.value) for r in asked if _verdict(r) == "wrong").items():
        print(f"    {truth:28} said {value:9} {count}")
    print(f"right {counts['right']} of {said} that are said ({counts['right'] / max(said, 1):.0%})")
    print(f"unknown {counts[UNKNOWN]} of {len(asked)} ({counts[UNKNOWN] / max(len(asked), 1):.0%})")
    for low, high in ((0.5, 0.7), (0.7, 0.85), (0.85, 1.0)):
        own = [_verdict(row) for row in asked if low <= row.said.confidence < high]
        print(f"confidence {low} to {high}: {own.count('right')} of {len(own)} right")
    unseen = [row for row in table if row.truth == UNSEEN]
    print(f"where the eye cannot tell: {sum(r.said.value != UNKNOWN for r in unseen)} of {len(unseen)} said")
    print(f"CPU median {sorted(seconds)[len(seconds) // 2]:.2f} s, most {max(seconds):.2f} s an object")


def _verdict(row: Row) -> str:
    if row.said.value == UNKNOWN:
        return UNKNOWN
    return "right" if row.said.value in row.truth.split() else "wrong"


if __name__ == "__main__":
    main()
