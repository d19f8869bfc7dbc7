"""Removes the materials of development assets, recovers them, and compares the families with those of the originals.

    python -m benchmarks.appearance.recovery ASSETS_DIR [--only TEXT] [--nameless | --keep-names] [--no-pictures]
    python -m benchmarks.appearance.recovery ASSETS_DIR --all | --sheet PNG

`recovery_truth.csv` names regions of assets and the families that they are of: by the name of the removed material, by
what a real object is made of, or by what a person sees. Materials, their names, textures and vertex colours are
removed; names of files and nodes stay, with `--nameless` they go too, with `--keep-names` those of materials stay. The
family of most of a region's area counts. With `--all` every readable development asset is recovered, compared or not.
Seconds are processor time of clues, ranking and pictures; pictures are drawn in forks of this process, as the warm
cells of a batch are. `--sheet` draws objects before, without and with recovered materials.
"""

from __future__ import annotations

import argparse
import csv
import os
import runpy
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from assetkit.materials.normalize import normalize
from assetkit.materials.recovery.pictures import draw
from assetkit.materials.recovery.recover import RecoveredModel, recover
from assetkit.materials.recovery.surfaces import RecoverySubject
from assetkit.package.preview_images import render_previews
from assetkit.parts.find import find_parts
from assetkit.scale.declared_units import is_reliable
from assetkit.stage import Canonical, Draft
from benchmarks.assets.part_materials import canonical_draft, region_mask
from benchmarks.assets.parts import category_of, stripped_of
from benchmarks.assets.truth_files import located
from geom.features.cavities import find_cavities
from geom.mesh.surface_distance import triangle_areas
from jobs.cell import CellResult, Limits
from jobs.warm import use_runner
from render.ready_studio import prepare_studio
from schemas.appearance.material import Material
from schemas.evidence import Evidence
from schemas.model import Model

TABLE = Path(__file__).with_name("recovery_truth.csv")
_TILE_PX = 200


class Row(NamedTuple):
    """One region: the families that are right, and the recovered one."""

    path: str
    region: str
    families: tuple[str, ...]
    recovered: Evidence[str]

    @property
    def is_right(self) -> bool:
        return self.recovered.value in self.families


def without_materials(draft: Draft, *, keep_names: bool = False) -> Draft:
    """The draft with no material, picture or colour, and no name of one unless they are kept."""
    canonical = draft[Canonical]
    bare_meshes = tuple(replace(mesh, colors=None) for mesh in canonical.meshes)
    meshes = bare_meshes if keep_names else tuple(replace(mesh, material=None) for mesh in bare_meshes)
    materials = tuple(Material(material.name) for material in draft.intake.model.materials) if keep_names else ()
    bare = replace(draft.intake.model, meshes=meshes, materials=materials, textures=())
    return replace(
        draft,
        intake=replace(draft.intake, model=bare),
        canonicalize=replace(canonical, meshes=meshes),
        appearance=normalize(bare).value,
    )


def subject_of(draft: Draft) -> RecoverySubject:
    """As the stage has it, with the category by names."""
    category = category_of(draft)
    cavities = find_cavities(draft[Canonical].solid)
    meshes = draft.model.meshes_by_id
    canonical = draft[Canonical]
    return RecoverySubject(
        category=category,
        file_name=Path(draft.source_name).stem,
        folders=draft.intake.folders,
        parts=find_parts(meshes, draft.model.materials, category, cavities=cavities).parts,
        is_metric=is_reliable(canonical.meters_per_unit, draft.intake.model.meters_per_unit),
    )


class ForkRunner:
    """Runs modules in forks of this process and adds up the processor time of these."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def run(self, name: str, arguments: Sequence[str], limits: Limits, env: dict[str, str]) -> CellResult:
        """How the fork ended."""
        pid = os.fork()
        if pid == 0:
            sys.argv = [name, *arguments]
            code = 1
            try:
                runpy.run_module(name, run_name="__main__")
            except SystemExit as end:
                code = int(end.code or 0)
            finally:
                os._exit(code)
        _, status, used = os.wait4(pid, 0)
        self.seconds += used.ru_utime + used.ru_stime
        code = os.waitstatus_to_exitcode(status)
        return CellResult("ok" if code == 0 else "crashed", code, "", used.ru_utime + used.ru_stime)


FORKS = ForkRunner()


def measured(draft: Draft, work_dir: Path | None) -> tuple[RecoveredModel, float]:
    """The recovered model, and the processor time that it took (s)."""
    model, subject = draft.model, subject_of(draft)
    started, before = time.process_time(), FORKS.seconds
    result = recover(model, subject, None if work_dir is None else partial(draw, work_dir=work_dir))
    return result, time.process_time() - started + FORKS.seconds - before


def compared(draft: Draft, recovered: RecoveredModel, group: list[dict[str, str]]) -> Iterator[Row]:
    """A row for each region of an object; `draft` has its materials still."""
    family_of = {mesh: surface.family for surface in recovered.surfaces for mesh in surface.meshes}
    meshes = draft.model.meshes
    area = np.concatenate([triangle_areas(m.points[m.triangles]) for m in meshes])
    of_mesh = np.repeat(np.arange(len(meshes)), [len(m.triangles) for m in meshes])
    names = [material.name for material in draft.model.materials]
    for row in group:
        inside = region_mask(row["region"], meshes, names)
        assert inside.any(), f"{row['path']}: nothing is in {row['region']}"
        share: dict[str, float] = {}
        for index in np.unique(of_mesh[inside]):
            family = family_of[meshes[index].id].value
            share[family] = share.get(family, 0.0) + float(area[inside & (of_mesh == index)].sum())
        family = max(share, key=lambda name: (share[name], name))
        evidence = max(
            (family_of[meshes[index].id] for index in np.unique(of_mesh[inside])),
            key=lambda e: (e.value == family, e.confidence),
        )
        yield Row(row["path"], row["region"], tuple(row["families"].split()), evidence)


def truth(only: str) -> dict[tuple[str, str], list[dict[str, str]]]:
    """The rows of the table whose path holds `only`, by path and way up."""
    groups: dict[tuple[str, str], list[dict[str, str]]] = {}
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if only in row["path"]:
                groups.setdefault((row["path"], row["up_axis"]), []).append(row)
    return groups


def report(rows: list[Row], seconds: list[float]) -> None:
    """Print shares, calibration, errors and times."""
    for row in rows:
        sign = "right" if row.is_right else "WRONG"
        print(f"{sign} {row.recovered.value:8} {row.recovered.confidence:.2f} {' '.join(row.families):16} {row.path}")
        print(f"      {row.region}: {row.recovered.method}")
    right = sum(row.is_right for row in rows)
    objects = {row.path for row in rows}
    whole = [p for p in objects if all(r.is_right for r in rows if r.path == p)]
    print(f"{right} of {len(rows)} regions right ({right / max(len(rows), 1):.0%})")
    print(f"{len(whole)} of {len(objects)} objects right in every region ({len(whole) / max(len(objects), 1):.0%})")
    sure = [row for row in rows if not row.is_right and row.recovered.confidence > 0.5]
    print(f"wrong above confidence 0.5: {len(sure)}")
    for low, high in ((0.0, 0.3), (0.3, 0.4), (0.4, 0.5), (0.5, 0.501), (0.501, 1.01)):
        inside = [row for row in rows if low <= row.recovered.confidence < high]
        mean = float(np.mean([row.recovered.confidence for row in inside])) if inside else 0.0
        print(f"confidence {low} to {high}: {sum(r.is_right for r in inside)} of {len(inside)} right, mean {mean:.2f}")
    times(seconds)


def times(seconds: list[float]) -> None:
    """Print the spread of the seconds of all objects."""
    ordered = sorted(seconds)
    late = sum(each > 2.0 for each in ordered)
    middle = ordered[len(ordered) // 2]
    print(f"{len(ordered)} objects: median {middle:.2f} s, most {ordered[-1]:.2f} s, above 2 s: {late}")


def sheet(models: list[tuple[Model, Model, Model]], target: Path, work_dir: Path) -> None:
    """One row per object: as it was, without materials, recovered."""
    picture = Image.new("RGB", (3 * _TILE_PX, len(models) * _TILE_PX), "white")
    for row, triple in enumerate(models):
        for column, model in enumerate(triple):
            data = render_previews(model, (), work_dir)["thumbnail"]
            file = work_dir / "tile.png"
            file.write_bytes(data)
            tile = Image.open(file).convert("RGB").resize((_TILE_PX, _TILE_PX), Image.Resampling.LANCZOS)
            picture.paste(tile, (column * _TILE_PX, row * _TILE_PX))
    picture.save(target)


def timed_assets(assets: Path, work_dir: Path, only: str) -> list[float]:
    """Seconds of every development asset that can be read."""
    seconds: list[float] = []
    with (assets / "manifest.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["split"] == "dev" and only in row["path"]]
    for row in rows:
        try:
            draft = without_materials(canonical_draft(*located(assets, f"dev/{row['path']}"), "auto"))
            _, spent = measured(draft, work_dir)
        except AssertionError:  # Intake or the canonical frame refuses it, as the manifest expects.
            continue
        seconds.append(spent)
        if spent > 2.0:
            print(f"{spent:.2f} s {row['path']}")
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--nameless", action="store_true")
    parser.add_argument("--keep-names", action="store_true")
    parser.add_argument("--no-pictures", action="store_true")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--sheet", type=Path)
    given = parser.parse_args()
    prepare_studio()
    table: list[Row] = []
    seconds: list[float] = []
    shown: list[tuple[Model, Model, Model]] = []
    with tempfile.TemporaryDirectory() as place, use_runner(FORKS):
        work_dir = Path(place)
        if given.all:
            times(timed_assets(given.assets, work_dir, given.only))
            return
        for (path, up_axis), group in truth(given.only).items():
            draft = canonical_draft(*located(given.assets, path), up_axis)
            bare = without_materials(draft, keep_names=given.keep_names)
            bare = without_materials(stripped_of(bare)) if given.nameless else bare
            recovered, spent = measured(bare, None if given.no_pictures else work_dir)
            table += compared(draft, recovered, group)
            seconds.append(spent)
            shown.append((draft.model, bare.model, recovered.model))
        if given.sheet is not None:
            sheet(shown, given.sheet, work_dir)
    report(table, seconds)


if __name__ == "__main__":
    main()
