"""Ingest every asset of a manifest and compare outcomes with what the manifest expects.

    python -m benchmarks.assets.manifest ASSETS_DIR OUT_DIR [--jobs N] [--only TEXT] [--mechanisms]

Prints the rows that differ and a summary; writes `OUT_DIR/table.json`. A row's asset folder is its root.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import time
from collections import Counter
from pathlib import Path
from statistics import median

from assetkit.batch.item_cells import LOST_CODES, Batch, default_jobs, run_items
from assetkit.blender import environment
from assetkit.options import Options
from assetkit.sources.discover import SourceAsset, discover
from benchmarks.assets.ingest_cost import processor_s
from cli.engines import SIMULATOR
from jobs.placement import Placement
from schemas.report import ReportItem

DESCRIPTIONS = {"urdf", "mjcf"}
# Codes that name a defect in other words than the manifest.
CODES_OF = {
    "cyclic_reference": {"link-cycle", "repeated-include"},
    "dangling_reference": {"unknown-class"},
    "duplicate_asset_name": {"duplicate-name"},
    "invalid_axis": {"zero-axis"},
    "massless_moving_body": {"missing-inertial"},
    "missing_dependency": {"missing-mesh"},
    "missing_joint_limit": {"missing-limit"},
    "missing_required_attribute": {"missing-attribute"},
    "zero_mass": {"invalid-mass"},
    "zero_mass_links": {"invalid-mass"},
}
CRASHES = {"asset/internal-error", *LOST_CODES.values()}
EXPECTED = {"accept": {"accepted", "repaired"}, "repair": {"repaired"}, "reject": {"rejected"}}


def verdict(row: dict[str, str], item: ReportItem) -> str:
    """`ok`, `reason` (right outcome, other reason) or `differs`. `review` is right where the row itself requires it."""
    asks_review = any(word.endswith("_review") for word in row["reason"].split(";"))
    if item.outcome.value not in EXPECTED[row["outcome"]] and not (asks_review and item.outcome.value == "review"):
        return "differs"
    if row["outcome"] == "accept":
        return "ok"
    codes = {r.name.replace("_", "-") for r in item.repairs} | {c.split("/")[1] for c in item.codes}
    words = row["reason"].split(";")
    expected_codes = {w.replace("_", "-") for w in words}.union(*(CODES_OF.get(w, set()) for w in words))
    return "ok" if codes & expected_codes else "reason"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--jobs", type=int, default=default_jobs())
    parser.add_argument("--only", default="")
    parser.add_argument("--mechanisms", action="store_true", help="only URDF, MJCF and what the manifest calls jointed")
    arguments = parser.parse_args()
    with (arguments.assets / "manifest.csv").open() as file:
        chosen = [row for row in csv.DictReader(file) if arguments.only in row["id"]]
    if arguments.mechanisms:
        chosen = [row for row in chosen if row["format"] in DESCRIPTIONS or row["articulated"] == "y"]
    rows = {str(arguments.assets / row["path"]): row for row in chosen}
    found = {c.given: c for c in discover([arguments.assets])}
    candidates: tuple[SourceAsset, ...] = tuple(found[path] for path in rows)
    started = time.monotonic()
    table: list[dict] = []
    batch = Batch(out=arguments.out, options=Options(), engine=SIMULATOR, placement=Placement(arguments.jobs))
    before_s = processor_s(os.getpid())
    for item in run_items(candidates, batch):
        row = rows[item.source]
        line = {
            "id": row["id"],
            "format": row["format"],
            "expected": row["outcome"],
            "reason": row["reason"],
            "outcome": item.outcome.value,
            "codes": item.codes,
            "repairs": [r.name for r in item.repairs],
            "packages": item.packages,
            "verdict": verdict(row, item),
            "seconds": item.seconds,
            "cached": item.cached,
            "crashed": bool(item.traceback),
            "cpu_s": None if arguments.jobs > 1 or item.cached else round(processor_s(os.getpid()) - before_s, 2),
        }
        before_s = processor_s(os.getpid())
        table.append(line)
        if line["verdict"] != "ok":
            errors = [d.headline for d in item.diagnostics if d.severity == "error"]
            wanted = f"expected {row['outcome']} ({row['reason']})"
            got = f"got {item.outcome.value} {list(item.codes)} {line['repairs']} {errors} {item.traceback[-300:]}"
            print(f"{line['verdict']:8} {row['id']:34} {wanted}, {got}", flush=True)
    summary(table, time.monotonic() - started)
    (arguments.out / "table.json").write_text(json.dumps(table, indent=1))


def summary(table: list[dict], wall_s: float) -> None:
    """Print counts per expectation, seconds per stage and the wall time."""
    unread = {"blend"} if environment.python() is None else set[str]()
    named = [t for t in table if t["format"] not in unread]
    for expected in EXPECTED:
        group = [t for t in named if t["expected"] == expected]
        print(expected, dict(Counter(t["verdict"] for t in group)), dict(Counter(t["outcome"] for t in group)))
    print("formats without their reader", dict(Counter(t["format"] for t in table if t["format"] in unread)))
    print("review", sum(t["outcome"] == "review" for t in named), "of", len(named))
    packaged = [t for t in named if t["packages"]]
    stages = sorted({s for t in packaged for s in t["seconds"]})
    for stage in stages:
        spent = [t["seconds"].get(stage, 0.0) for t in packaged]
        print(f"  {stage:14} median {median(spent):6.2f} s  sum {sum(spent):8.1f} s")
    print("crashes", sum(t["crashed"] or bool(CRASHES & set(t["codes"])) for t in table))
    if costs := [t["cpu_s"] for t in packaged if t["cpu_s"] is not None]:
        print(f"  processor time median {median(costs):6.2f} s  max {max(costs):.1f} s")
    if packaged:
        totals = [sum(t["seconds"].values()) for t in packaged]
        print(f"  asset          median {median(totals):6.2f} s  max {max(totals):.1f} s")
    print(f"wall {wall_s:.1f} s, {len(table)} rows, {sum(bool(t['cached']) for t in table)} cached")


if __name__ == "__main__":
    main()
