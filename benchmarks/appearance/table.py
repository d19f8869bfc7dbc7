"""Results of the comparison by FLIP: targets, rows, and the table in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean, median

# Targets of issue 32: mean FLIP of every view, and the median over samples of the mean over views.
MOST_PER_VIEW, MOST_MEDIAN = 0.10, 0.05
HEADINGS = (
    "sample",
    "outcome",
    "front",
    "left",
    "back",
    "top",
    "mean",
    "noise",
    "by Mana",
    "between renderers",
    "not shown",
)


@dataclass(frozen=True)
class Comparison:
    """One sample: mean FLIP by view.

    outcome  of the ingest.
    apart    has glass or a clear coat.
    lacking  fields of its materials that the UsdPreviewSurface, which Blender reads, does not show.
    cycles   source against release, both by Cycles; own: both by Mana.
    noise    source against itself with other random numbers, by Cycles.
    between  release by Cycles against release by Mana.
    """

    name: str
    outcome: str
    apart: bool
    lacking: tuple[str, ...]
    cycles: dict[str, float]
    noise: dict[str, float]
    own: dict[str, float]
    between: dict[str, float]

    @property
    def meets(self) -> bool:
        """Whether every view by Cycles is within the target of a view."""
        return max(self.cycles.values()) <= MOST_PER_VIEW

    def row(self) -> str:
        """The row of the table; views above the target are bold."""
        views = [f"**{value:.3f}**" if value > MOST_PER_VIEW else f"{value:.3f}" for value in self.cycles.values()]
        means = [f"{fmean(each.values()):.3f}" for each in (self.cycles, self.noise, self.own, self.between)]
        return _row((self.name, self.outcome, *views, *means, ", ".join(self.lacking)))


@dataclass(frozen=True)
class Refusal:
    """A sample that could not be compared, and why."""

    name: str
    reason: str

    def row(self) -> str:
        """The row of the table."""
        return f"| {self.name} | not compared: {self.reason} |"


def table(results: Sequence[Comparison | Refusal]) -> str:
    """Two tables, surfaces and then glass and coats, each with its summary, then the samples that were not compared."""
    compared = [result for result in results if isinstance(result, Comparison)]
    refused = [result for result in results if isinstance(result, Refusal)]
    lines: list[str] = []
    for title, apart in (("Surfaces", False), ("Glass and clear coats", True)):
        group = [result for result in compared if result.apart == apart]
        if group:
            lines += [f"### {title}", "", summary(group), "", _row(HEADINGS), "|" + "---|" * len(HEADINGS)]
            lines += [*(result.row() for result in group), ""]
    lines += [f"- {result.name} was not compared: {result.reason}" for result in refused]
    return "\n".join(lines) + "\n"


def summary(group: Sequence[Comparison]) -> str:
    """How many samples meet the target of a view, and the median over samples beside its target."""
    middle = median(fmean(result.cycles.values()) for result in group)
    worst = max(max(result.cycles.values()) for result in group)
    above = [result.name for result in group if not result.meets]
    return (
        f"{len(group) - len(above)} of {len(group)} samples have every view at or below {MOST_PER_VIEW:.2f}; median "
        f"over samples {middle:.3f} (target {MOST_MEDIAN:.2f}), worst view {worst:.3f}. "
        f"Above: {', '.join(above) if above else 'none'}."
    )


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
