"""Compares estimated mass and volume with the truth of a manifest, without colliders, pictures or packages.

    python -m benchmarks.assets.masses.mass ASSETS_DIR OUT.jsonl [--only TEXT]

Takes the rows of `ASSETS_DIR/manifest.csv` with `mass_kg` or `truth_volume_m3` in the formats that are read; of robot
descriptions with a published mass, which state one of their own, the mesh. One process, one object after the other.
Objects with a published mass are estimated three times: as they are, with the rows of the prior table left out that
were written from them (`own row left out`), and with names of files, folders, nodes and materials taken away
(`stripped`). Finished rows stand in OUT.jsonl and are not made again; delete it to start anew.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from assetkit.geometry.canonical_model import canonicalize
from assetkit.mass.estimate import mass_evidence
from assetkit.options import Options
from assetkit.physics.mass_inputs import mass_inputs_of
from assetkit.readers.by_format import READERS
from assetkit.sources.discover import SourceAsset, discover
from assetkit.stage import Draft, Intake, Tools
from assetkit.stages.intake import ReadSource
from assetkit.stages.semantics import DescribeObject
from geom.features.cavities import find_cavities
from sim.fake import FakeSimulator

MAX_SPAN, MOST_WANTED_SPAN = 30.0, 10.0
VOLUME_TOLERANCE = 0.01
NAMED, OWN_ROW, STRIPPED = "named", "own row left out", "stripped"
# Meshes of robot descriptions whose file states a mass of its own.
MESHES = {
    "ycb_001_chips_can_urdf_missingmesh": "collision_vhacd.obj",
    "ycb_005_tomato_soup_can_urdf": "textured_simple_reoriented.obj",
    "ycb_011_banana_urdf": "textured_simple_reoriented.obj",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    with (arguments.assets / "manifest.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if (r["mass_kg"] or r["truth_volume_m3"]) and arguments.only in r["id"]]
    rows = [r for r in rows if r["id"] in MESHES or (r["format"] in READERS and r["outcome"] != "reject")]
    done = [json.loads(line) for line in arguments.out.read_text().splitlines()] if arguments.out.exists() else []
    table = {line["id"]: line for line in done}
    found = {c.given: c for c in discover([arguments.assets])}
    with arguments.out.open("a") as out:
        for row in rows:
            if row["id"] not in table:
                path = arguments.assets / row["path"]
                mesh = MESHES.get(row["id"])
                candidate = discover([path.with_name(mesh)], root=arguments.assets)[0] if mesh else found[str(path)]
                table[row["id"]] = measured(row, candidate)
                out.write(json.dumps(table[row["id"]]) + "\n")
                out.flush()
            show(table[row["id"]])
    summary([table[row["id"]] for row in rows])


def measured(row: dict[str, str], candidate: SourceAsset) -> dict:
    """Our figures for one row beside its truth."""
    item = ReadSource().run(candidate, Options()).objects[0]
    name = candidate.file.path.name
    runs = {NAMED: estimated(row["id"], name, item)}
    if row["mass_kg"]:
        runs[OWN_ROW] = estimated(row["id"], name, item, without=own_row(row["id"]))
        runs[STRIPPED] = estimated("thing", "thing" + candidate.file.path.suffix, nameless(item))
    return {
        "id": row["id"],
        "true_volume_m3": float(row["truth_volume_m3"] or "nan"),
        "true_mass_kg": float(row["mass_kg"] or "nan"),
        "runs": runs,
    }


def estimated(asset_id: str, name: str, item: Intake, *, without: str = "") -> dict:
    """Mass and volume of one object called `name`; `without` is left out of the prior table."""
    canonical = canonicalize(item, name, Options()).value
    assert canonical is not None, f"{asset_id} has no size"
    draft = Draft(asset_id, name, item, canonicalize=canonical)
    described = DescribeObject().run(draft, Tools(FakeSimulator(), Path(), Options())).value
    mass_inputs = replace(mass_inputs_of(replace(draft, semantics=described), canonical), excluded_row=without)
    evidence = mass_evidence(canonical.solid, [name], replace(mass_inputs, cavities=find_cavities(canonical.solid)))
    return {
        "kind": canonical.solid.kind,
        "category": mass_inputs.category,
        "material": evidence.material.value,
        "source": evidence.mass_kg.source,
        "volume_m3": canonical.section.volume_m3.value,
        "mass_kg": evidence.mass_kg.value,
        "bounds_kg": evidence.mass_kg.bounds or (evidence.mass_kg.value,) * 2,
        "method": evidence.mass_kg.method,
    }


def own_row(asset_id: str) -> str:
    """The key of the rows that the prior table has of an asset: "ycb 010" of drake_010_potted_meat_can."""
    number = next((part for part in asset_id.split("_") if part.isdigit() and len(part) == 3), "")
    return f"ycb {number}" if number else " ".join(asset_id.split("_")[:2])


def nameless(item: Intake) -> Intake:
    """The same object with every name taken away."""
    meshes = tuple(replace(m, name="", source_path=f"/{i}") for i, m in enumerate(item.model.meshes))
    materials = tuple(replace(material, name="") for material in item.model.materials)
    model = replace(item.model, meshes=meshes, materials=materials, metadata={})
    return replace(item, model=model, folder="", folders=())


def show(line: dict) -> None:
    """One row of the table, and a line for each way of asking."""
    named, mass, volume = line["runs"][NAMED], line["true_mass_kg"], line["true_volume_m3"]
    error = "" if volume != volume else f"volume {100 * (named['volume_m3'] / volume - 1):+.3f} %"
    truth = "" if mass != mass else f"true {mass:6.4g} kg"
    print(f"{line['id']:36} {truth}{error}")
    for title, run in line["runs"].items():
        low, high = run["bounds_kg"]
        figures = f"{run['mass_kg']:9.4g} kg in [{low:.4g}, {high:.4g}] x{high / low:4.1f}"
        told = "" if mass != mass else "inside" if low <= mass <= high else "OUTSIDE"
        print(f"    {title:18} {run['kind']:6} {run['category'] or '-':13} {run['material']:9} {figures} {told}")


def summary(table: Sequence[dict]) -> None:
    """Counts over all rows."""
    sized = [t for t in table if t["true_volume_m3"] == t["true_volume_m3"]]
    if sized:
        errors = [abs(t["runs"][NAMED]["volume_m3"] / t["true_volume_m3"] - 1.0) for t in sized]
        within = sum(e <= VOLUME_TOLERANCE for e in errors)
        print(f"volumes within 1 %: {within} of {len(sized)}, worst {max(errors):.2%}")
    weighed = [t for t in table if t["true_mass_kg"] == t["true_mass_kg"]]
    for title in (NAMED, OWN_ROW, STRIPPED):
        rows = [(t["true_mass_kg"], *t["runs"][title]["bounds_kg"]) for t in weighed]
        if rows:
            print(f"published masses, {title}: {_described(rows)}")
    named = [(t["true_mass_kg"], *t["runs"][NAMED]["bounds_kg"]) for t in weighed if t["runs"][NAMED]["category"]]
    if named:
        print(f"published masses, {NAMED}, of a known category: {_described(named)}")
    widths = [t["runs"][NAMED]["bounds_kg"][1] / t["runs"][NAMED]["bounds_kg"][0] for t in table]
    print(f"widest bounds of all: x{max(widths):.1f}; over x{MAX_SPAN:g}: {sum(w > 1.001 * MAX_SPAN for w in widths)}")


def _described(rows: Sequence[tuple[float, float, float]]) -> str:
    widths = [high / low for _, low, high in rows]
    inside = sum(low <= mass <= high for mass, low, high in rows)
    mean = math.exp(sum(map(math.log, widths)) / len(widths))
    wide = sum(width > 1.001 * MOST_WANTED_SPAN for width in widths)
    most = f"x{max(widths):.1f} at most, {wide} over x{MOST_WANTED_SPAN:g}"
    return f"{inside} of {len(rows)} inside, x{mean:.2f} in the geometric mean, {most}"


if __name__ == "__main__":
    main()
