"""Mass and volume beside the truth of a manifest, without colliders, pictures or packages.

    python -m benchmarks.mass ASSETS_DIR OUT.jsonl [--only TEXT]

Takes the rows of `ASSETS_DIR/manifest.csv` with `mass_kg` or `truth_volume_m3` in the formats that are read, one
process, one object after the other. Finished rows stand in OUT.jsonl and are not made again; delete it to start anew.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from dataclasses import replace
from pathlib import Path

from assetkit.discover import Candidate, discover
from assetkit.mass import mass_evidence
from assetkit.options import Options
from assetkit.stage import Draft, Tools
from assetkit.stages.author_physics import clues_of
from assetkit.stages.canonicalize import canonicalize
from assetkit.stages.intake import READERS, take_in
from assetkit.stages.semantics import DescribeObject
from geom.cavity import find_cavities
from sim.fake import FakeSimulator

MAX_SPAN = 30.0
VOLUME_TOLERANCE = 0.01


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    with (arguments.assets / "manifest.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["mass_kg"] or r["truth_volume_m3"]]
    rows = [r for r in rows if r["format"] in READERS and r["outcome"] != "reject" and arguments.only in r["id"]]
    done = [json.loads(line) for line in arguments.out.read_text().splitlines()] if arguments.out.exists() else []
    table = {line["id"]: line for line in done}
    found = {c.given: c for c in discover([arguments.assets])}
    with arguments.out.open("a") as out:
        for row in rows:
            if row["id"] not in table:
                table[row["id"]] = measured(row, found[str(arguments.assets / row["path"])])
                out.write(json.dumps(table[row["id"]]) + "\n")
                out.flush()
            show(table[row["id"]])
    summary([table[row["id"]] for row in rows])


def measured(row: dict[str, str], candidate: Candidate) -> dict:
    """Our figures for one row beside its truth."""
    name = candidate.file.path.name
    item = take_in(candidate, Options()).objects[0]
    canonical = canonicalize(item, name, Options()).value
    assert canonical is not None, f"{row['id']} has no size"
    draft = Draft(row["id"], name, item, canonicalize=canonical)
    described = DescribeObject().run(draft, Tools(FakeSimulator(), Path(), Options())).value
    clues = clues_of(replace(draft, semantics=described), canonical)
    found = mass_evidence(canonical.solid, [name], replace(clues, cavities=find_cavities(canonical.solid)))
    low, high = found.mass_kg.bounds or (found.mass_kg.value,) * 2
    return {
        "id": row["id"],
        "kind": canonical.solid.kind,
        "category": clues.category,
        "material": found.material.value,
        "source": found.mass_kg.source,
        "volume_m3": canonical.section.volume_m3.value,
        "true_volume_m3": float(row["truth_volume_m3"] or "nan"),
        "mass_kg": found.mass_kg.value,
        "bounds_kg": [low, high],
        "true_mass_kg": float(row["mass_kg"] or "nan"),
        "method": found.mass_kg.method,
    }


def show(line: dict) -> None:
    """One row of the table."""
    low, high = line["bounds_kg"]
    mass, volume = line["true_mass_kg"], line["true_volume_m3"]
    inside = "" if mass != mass else "inside" if low <= mass <= high else "OUTSIDE"
    error = "" if volume != volume else f"volume {100 * (line['volume_m3'] / volume - 1):+.3f} %"
    figures = f"{line['mass_kg']:9.4g} kg in [{low:.4g}, {high:.4g}] x{high / low:4.1f}"
    print(f"{line['id']:32} {line['kind']:6} {line['material']:10} {figures} true {mass:6.4g} {inside:8}{error}")


def summary(table: list[dict]) -> None:
    """Counts over all rows."""
    weighed = [t for t in table if t["true_mass_kg"] == t["true_mass_kg"]]
    inside = [t for t in weighed if t["bounds_kg"][0] <= t["true_mass_kg"] <= t["bounds_kg"][1]]
    sized = [t for t in table if t["true_volume_m3"] == t["true_volume_m3"]]
    errors = [abs(t["volume_m3"] / t["true_volume_m3"] - 1.0) for t in sized]
    widths = [t["bounds_kg"][1] / t["bounds_kg"][0] for t in table]
    print(f"masses inside their bounds: {len(inside)} of {len(weighed)}")
    print(f"volumes within 1 %: {sum(e <= VOLUME_TOLERANCE for e in errors)} of {len(sized)}, worst {max(errors):.2%}")
    weights = [t["bounds_kg"][1] / t["bounds_kg"][0] for t in weighed]
    mean = math.exp(sum(map(math.log, weights)) / len(weights))
    print(f"bounds of those with a published mass: x{mean:.2f} in the geometric mean")
    print(f"widest bounds: x{max(widths):.1f}; wider than x{MAX_SPAN:g}: {sum(w > 1.001 * MAX_SPAN for w in widths)}")


if __name__ == "__main__":
    main()
