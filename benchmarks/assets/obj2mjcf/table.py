"""The table of `benchmarks.assets.obj2mjcf.compare`: its rows, as CSV and Markdown, and the medians of paired
ratios.
"""

from __future__ import annotations

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from statistics import median

SINGLE_SHAPES = {"box", "sphere", "capsule", "cylinder", "hull"}  # Methods that do not take a mesh apart.
HEADINGS = (
    *("file", "triangles", "ours", "method", "CPU s", "obj2mjcf CPU s", "ratio", "MiB", "obj2mjcf MiB"),
    *("hulls", "obj2mjcf hulls", "p95 %", "obj2mjcf p95 %", "mean %", "obj2mjcf mean %"),
)


@dataclass(frozen=True)
class Row:
    """One file. `ours_` and `theirs_`: processor seconds, MiB, hulls, distances in percent (see `Likeness`)."""

    file: str
    triangles: int
    ours_ended: str
    ours_method: str
    ours_cpu_s: float
    ours_wall_s: float
    ours_process_mb: float
    ours_together_mb: float
    ours_hulls: int
    ours_p95: float
    ours_mean: float
    ours_largest: float
    theirs_ended: str
    theirs_cpu_s: float
    theirs_wall_s: float
    theirs_process_mb: float
    theirs_together_mb: float
    theirs_hulls: int
    theirs_p95: float
    theirs_mean: float
    theirs_largest: float

    @property
    def both_decomposed(self) -> bool:
        """Whether both took the mesh apart, rather than ours standing in with one box, cylinder, hull ..."""
        return self.compared and not SINGLE_SHAPES & set(self.ours_method.split("+"))

    @property
    def compared(self) -> bool:
        """Whether both came to an end with collision shapes."""
        return self.ours_hulls > 0 and self.theirs_ended == "ok"


def read_rows(path: Path) -> list[Row]:
    """Rows of an earlier run."""
    if not path.is_file():
        return []
    kinds = {f.name: {"int": int, "float": float, "str": str}[str(f.type)] for f in fields(Row)}
    with path.open(newline="") as file:
        return [Row(**{key: kinds[key](value) for key, value in row.items()}) for row in csv.DictReader(file)]


def write_rows(rows: list[Row], out: Path) -> None:
    with (out / "assets.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, [f.name for f in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
    heading = f"| {' | '.join(HEADINGS)} |\n|{'---|' * len(HEADINGS)}\n"
    body = "".join(line(row) + "\n" for row in sorted(rows, key=lambda r: r.file))
    (out / "assets.md").write_text(f"{heading}{body}\n{summary(rows)}\n")


def line(row: Row) -> str:
    """A row of the table."""
    ended = "" if row.theirs_ended == "ok" else f" ({row.theirs_ended})"
    cells = (
        row.file,
        row.triangles,
        row.ours_ended,
        row.ours_method or "none",
        f"{row.ours_cpu_s:.1f}",
        f"{row.theirs_cpu_s:.1f}{ended}",
        f"{row.ours_cpu_s / row.theirs_cpu_s:.2f}" if row.theirs_cpu_s else "",
        f"{row.ours_together_mb:.0f}",
        f"{row.theirs_together_mb:.0f}",
        row.ours_hulls,
        row.theirs_hulls,
        f"{row.ours_p95:.2f}",
        f"{row.theirs_p95:.2f}",
        f"{row.ours_mean:.2f}",
        f"{row.theirs_mean:.2f}",
    )
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def summary(rows: list[Row]) -> str:
    """Medians of paired ratios (ours over theirs), over all compared files and over those both decomposed."""
    text = [f"{len(rows)} files; compared {sum(r.compared for r in rows)}."]
    for name, group in (
        ("all compared", [r for r in rows if r.compared]),
        ("both decomposed", [r for r in rows if r.both_decomposed]),
    ):
        if not group:
            continue
        cpu = sorted(r.ours_cpu_s / r.theirs_cpu_s for r in group)
        text.append(
            f"- {name}, {len(group)} files: CPU ratio median {median(cpu):.2f} (min {cpu[0]:.2f}, max {cpu[-1]:.2f}), "
            f"not slower in {sum(c <= 1.0 for c in cpu)}; CPU seconds in all {total(group, 'ours_cpu_s'):.0f} against "
            f"{total(group, 'theirs_cpu_s'):.0f}; memory ratio median {ratio(group, 'together_mb'):.2f} (all processes "
            f"together), {ratio(group, 'process_mb'):.2f} (largest process); p95 {beside(group, 'p95')}; mean distance "
            f"{beside(group, 'mean')}; hulls median {middle(group, 'ours_hulls'):g} against "
            f"{middle(group, 'theirs_hulls'):g}"
        )
    failed = [f"{r.file}: {r.theirs_ended}" for r in rows if r.theirs_ended != "ok"]
    refused = [f"{r.file}: {r.ours_ended}" for r in rows if not r.ours_hulls]
    text.append(f"- obj2mjcf did not finish ({len(failed)}): " + ("; ".join(failed) or "none"))
    text.append(f"- ours made no package ({len(refused)}): " + ("; ".join(refused) or "none"))
    return "\n".join(text)


def total(rows: list[Row], field: str) -> float:
    return sum(getattr(row, field) for row in rows)


def middle(rows: list[Row], field: str) -> float:
    return median(getattr(row, field) for row in rows)


def ratio(rows: list[Row], field: str) -> float:
    """Median of ours over theirs."""
    return median(getattr(row, f"ours_{field}") / getattr(row, f"theirs_{field}") for row in rows)


def beside(rows: list[Row], field: str) -> str:
    """Medians of a distance side by side, and in how many rows ours is not larger (to the last digit shown)."""
    ours, theirs = f"ours_{field}", f"theirs_{field}"
    good = sum(getattr(row, ours) <= getattr(row, theirs) + 0.005 for row in rows)
    return f"median {middle(rows, ours):.2f} % against {middle(rows, theirs):.2f} %, equal or better in {good}"
