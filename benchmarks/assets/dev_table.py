"""What became of every asset of a manifest, beside what is known about it. Reads the output of
`benchmarks.assets.manifest`.

    python -m benchmarks.assets.dev_table ASSETS_DIR OUT_DIR [--only TEXT] [--json FILE]

One row per asset: outcome, collider (method, shapes, volume ratio, 95th-percentile distance in % of the diagonal), mass
with bounds beside the true mass, released size beside the mesh's own true size (native extent times declared unit) and
the published caliper size, seconds. Sizes are sorted, because frames differ by quarter turns. `!` marks a size more
than 1 % off where the unit is declared, and a true mass outside the bounds. Aggregates follow.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median

import numpy as np

from assetkit.package.record import RECORD
from geom.pose import matrix_of
from schemas.asset import AssetRecord

SIZE_TOLERANCE = 0.01
FLAT = 1e-3  # An axis this small beside the largest is compared with the largest: sheets have no thickness.
Size = tuple[float, ...]


@dataclass(frozen=True)
class Row:
    """One asset; sizes in metres, sorted descending; masses in kilograms; None where nothing is known."""

    id: str
    format: str
    outcome: str
    expected: str
    packages: int
    method: str
    shapes: int
    volume_ratio: float | None
    p95: float | None
    mass_kg: float | None
    mass_bounds_kg: tuple[float, float] | None
    true_mass_kg: float | None
    size_m: Size
    own_size_m: Size
    size_error: float | None
    unit: str
    caliper_m: Size
    seconds: float

    @property
    def mass_inside(self) -> bool | None:
        """Whether the true mass lies within the bounds; None where one of them is unknown."""
        if self.true_mass_kg is None or self.mass_bounds_kg is None:
            return None
        return self.mass_bounds_kg[0] <= self.true_mass_kg <= self.mass_bounds_kg[1]


def parse_size(text: str) -> Size:
    """The finite numbers of "0.2x0.1x0.3", sorted descending; empty when there are none or one is not finite."""
    try:
        numbers = [float(part) for part in text.split("x")] if text else []
    except ValueError:
        return ()
    return tuple(sorted(numbers, reverse=True)) if all(map(math.isfinite, numbers)) else ()


def size_error(size: Size, true_size: Size) -> float | None:
    """The largest relative difference along an axis; None where the sizes cannot be compared."""
    if len(size) != 3 or len(true_size) != 3 or true_size[0] <= 0:
        return None
    return max(
        abs(a - b) / (b if b > FLAT * true_size[0] else true_size[0]) for a, b in zip(size, true_size, strict=True)
    )


def whole_size(records: Sequence[AssetRecord]) -> Size:
    """The bounding box of all packages of one file, put back where they stood in it."""
    if not records:
        return ()
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for record in records:
        x, y, z = record.geometry.extent_m.value
        corners = np.array([[sx * x, sy * y, sz * z] for sx in (-0.5, 0.5) for sy in (-0.5, 0.5) for sz in (0.0, 1.0)])
        corners_in_file = (corners - record.geometry.origin_offset_m) @ matrix_of(
            np.array(record.geometry.source_quat_wxyz)
        )
        low, high = np.minimum(low, corners_in_file.min(axis=0)), np.maximum(high, corners_in_file.max(axis=0))
    return tuple(sorted((float(e) for e in high - low), reverse=True))


def row_of(known: dict[str, str], item: dict, records: Sequence[AssetRecord]) -> Row:
    """One row from the manifest's line, the outcome and the released records."""
    chosen = [next(c for c in r.physics.candidates if c.method == r.physics.collision_method) for r in records]
    ratios = [c.volume_ratio for c in chosen if c.volume_ratio is not None]
    masses = [r.physics.mass_kg for r in records]
    bounds = [m.bounds for m in masses if m.bounds is not None]
    size = whole_size(records)
    true_size = tuple(e * float(known["meters_per_unit"] or 0) for e in parse_size(known["measured_extent_native"]))
    declared = bool(records) and records[0].source.meters_per_unit.source == "declared"
    return Row(
        id=known["id"],
        format=known["format"],
        outcome=item["outcome"],
        expected=known["outcome"],
        packages=len(records),
        method="+".join(sorted({c.method for c in chosen})),
        shapes=sum(c.shapes for c in chosen),
        volume_ratio=max(ratios, key=lambda r: abs(math.log(max(r, 1e-9)))) if ratios else None,
        p95=max((max(c.outside_p95, c.missing_p95) for c in chosen), default=None),
        mass_kg=sum(m.value for m in masses) if masses else None,
        mass_bounds_kg=(sum(b[0] for b in bounds), sum(b[1] for b in bounds))
        if bounds and len(bounds) == len(masses)
        else None,
        true_mass_kg=float(known["mass_kg"]) if known["mass_kg"] else None,
        size_m=size,
        own_size_m=true_size if known["meters_per_unit"] else (),
        size_error=size_error(size, true_size) if known["meters_per_unit"] else None,
        unit="declared" if declared else records[0].source.meters_per_unit.source if records else "",
        caliper_m=parse_size(known["dims_m"]),
        seconds=sum(item["seconds"].values()),
    )


COLUMNS: tuple[tuple[str, Callable[[Row], str]], ...] = (
    ("asset", lambda r: r.id),
    ("outcome", lambda r: r.outcome),
    ("collider", lambda r: r.method),
    ("shapes", lambda r: str(r.shapes) if r.packages else ""),
    ("volume ratio", lambda r: "" if r.volume_ratio is None else f"{r.volume_ratio:.2f}"),
    ("p95 %", lambda r: "" if r.p95 is None else f"{100 * r.p95:.2f}"),
    ("mass kg", lambda r: _mass(r)),
    ("true kg", lambda r: "" if r.true_mass_kg is None else f"{r.true_mass_kg:g}{_mark(r.mass_inside is False)}"),
    ("size m", lambda r: _size(r.size_m)),
    ("own size m", lambda r: _size(r.own_size_m)),
    ("off %", lambda r: "" if r.size_error is None else f"{100 * r.size_error:.2f}{_mark(_off(r))}"),
    ("unit", lambda r: r.unit),
    ("caliper m", lambda r: _size(r.caliper_m)),
    ("s", lambda r: f"{r.seconds:.1f}"),
)


def table(rows: Sequence[Row]) -> str:
    """The rows as a Markdown table."""
    lines = [[name for name, _ in COLUMNS], ["---"] * len(COLUMNS)]
    lines += [[show(row) for _, show in COLUMNS] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def summary(rows: Sequence[Row]) -> str:
    """The aggregate lines."""
    packaged = [r for r in rows if r.packages]
    sized = [r for r in packaged if r.size_error is not None and r.unit == "declared"]
    others = [r for r in packaged if r.size_error is not None and r.unit != "declared"]
    weighed = [r for r in packaged if r.mass_inside is not None]
    p95 = [100 * r.p95 for r in packaged if r.p95 is not None]
    ratios = [r.volume_ratio for r in packaged if r.volume_ratio is not None]
    lines = [
        f"{len(rows)} assets: {_counts(r.outcome for r in rows)}; {sum(r.packages for r in packaged)} packages",
        f"declared unit: {sum(_fits(r) for r in sized)} of {len(sized)} sizes within 1 % of the mesh's own",
        f"unit by other evidence: {sum(_fits(r) for r in others)} of {len(others)} within 1 %",
        f"true mass inside the bounds: {sum(r.mass_inside is True for r in weighed)} of {len(weighed)}",
        f"colliders: {_counts(r.method for r in packaged)}; shapes median {_median([r.shapes for r in packaged])}",
        f"p95 median {_median(p95)} %, largest {max(p95, default=math.nan):.2f} %; volume ratio {_median(ratios)}",
        f"seconds median {_median([r.seconds for r in packaged])}, sum {sum(r.seconds for r in rows):.0f}",
    ]
    return "\n".join(lines)


def _mass(row: Row) -> str:
    if row.mass_kg is None:
        return ""
    low, high = row.mass_bounds_kg or (math.nan, math.nan)
    return f"{row.mass_kg:.3g} [{low:.3g} .. {high:.3g}]"


def _size(size: Size) -> str:
    return " x ".join(f"{e:.4g}" for e in size)


def _fits(row: Row) -> bool:
    return row.size_error is not None and row.size_error <= SIZE_TOLERANCE


def _off(row: Row) -> bool:
    return row.unit == "declared" and row.size_error is not None and not _fits(row)


def _mark(wrong: bool) -> str:
    return " !" if wrong else ""


def _median(values: Sequence[float]) -> str:
    return f"{median(values):.2f}" if values else "-"


def _counts(values: Iterable[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(values).items(), key=lambda kv: -kv[1]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("assets", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", default="", help="rows whose id contains this")
    parser.add_argument("--json", type=Path, help="write the rows here too")
    arguments = parser.parse_args()
    with (arguments.assets / "manifest.csv").open() as file:
        known = {row["id"]: row for row in csv.DictReader(file)}
    rows = []
    for made in json.loads((arguments.out / "table.json").read_text()):
        if arguments.only in made["id"]:
            files = [arguments.out / name / RECORD for name in made["packages"]]
            records = [AssetRecord.model_validate_json(f.read_bytes()) for f in files]
            rows.append(row_of(known[made["id"]], made, records))
    print(table(rows))
    print()
    print(summary(rows))
    if arguments.json:
        arguments.json.write_text(json.dumps([asdict(row) for row in rows], indent=1))


if __name__ == "__main__":
    main()
