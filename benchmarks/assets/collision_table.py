"""Markdown tables of `benchmarks.assets.collision`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from statistics import median

Rows = Sequence[dict[str, str]]


def print_tables(ours: Rows, plain: Rows) -> None:
    """Totals, every exception with its reason, and the comparison with plain CoACD."""
    met = [row for row in ours if not row["fails"]]
    seconds = [float(row["cpu_s"]) for row in ours]
    print(f"\n{len(met)} of {len(ours)} meet the bar ({100 * len(met) / max(len(ours), 1):.1f} %).")
    print("methods:", ", ".join(f"{m} {n}" for m, n in Counter(row["method"] for row in ours).most_common()))
    print(f"CPU s: median {median(seconds):.2f}, largest {max(seconds):.1f}, sum {sum(seconds):.0f}")
    print("openings filled:", sum("opening" in row["fails"] for row in ours), end="; ")
    print("that let a ball out through a gap:", sum("leak" in row["fails"] for row in ours))
    print("\n| exception | method | hulls | volume ratio | p95 outside / missing, % | CPU s | misses |")
    print("|---|---|---|---|---|---|---|")
    for row in ours:
        if row["fails"]:
            print(
                f"| {row['name']} | {row['method']} | {row['hulls']} | {row['volume_ratio']} "
                f"| {row['outside_p95']} / {row['missing_p95']} | {row['cpu_s']} | {row['fails']} |"
            )
    if plain:
        print("\n| mesh | faces | plain CPU s | ours | plain hulls | ours | plain largest hull | plain ratio | ours |")
        print("|---|---|---|---|---|---|---|---|---|")
    by_name = {row["name"]: row for row in ours}
    for row in plain:
        own = by_name[row["name"]]
        print(
            f"| {row['name']} | {row['faces']} | {float(row['cpu_s']):.1f} | {own['cpu_s']} | {row['hulls']} "
            f"| {own['hulls']} | {row['largest_hull']} | {row['volume_ratio']} | {own['volume_ratio']} |"
        )
