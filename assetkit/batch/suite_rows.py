"""The suites of acceptance of a package as rows of a table for people: what was exercised, and how far it holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from schemas.acceptance import Check, SuiteSection
from schemas.diagnostics import Diagnostic

# Folder of a library with a GIF per package: beside the packages, whose files are those that their records hash, and
# under a name that no package has (`assetkit.sources.discover.slug` gives no hyphen followed by a word).
VIDEOS = "acceptance-videos"


@dataclass(frozen=True)
class SuiteRow:
    """One suite.

    outcome     "passed", "failed" or "not run".
    passed, of  checks at the values of the package.
    why         the reason why it was not run, or the first failed check with its value and bound; else "".
    margins     within which friction or mass it holds, in words; () where that was not tried, or where it holds for
                each alone and not for both together: `corners` then says so.
    corners     passed and all ends of the bounds of friction and mass together, as "3 of 4"; "" where none were tried.
    repeats     the same for other steps of the engine, with those at which it fails.
    """

    name: str
    outcome: str
    passed: int
    of: int
    why: str
    margins: tuple[str, ...]
    corners: str
    repeats: str

    @property
    def remark(self) -> str:
        """The row in a few words, without its name and outcome."""
        if not self.of:
            return self.why
        parts = [f"{self.passed} of {self.of} checks", self.why, *self.margins]
        parts.append("" if self.margins or not self.corners else f"{self.corners} ends of friction and mass hold")
        parts.append(f"steps of the engine: {self.repeats}" if "fails" in self.repeats else "")
        return "; ".join(filter(None, parts))


@dataclass(frozen=True)
class WithdrawnRole:
    """A finding that took an inferred role off the record, and the figures that it rests on."""

    headline: str
    figures: tuple[str, ...]


def suite_rows(suites: Sequence[SuiteSection]) -> tuple[SuiteRow, ...]:
    """A row for each suite, in order."""
    return tuple(_row(suite) for suite in suites)


def withdrawn_roles(diagnostics: Sequence[Diagnostic]) -> tuple[WithdrawnRole, ...]:
    """The roles that suites did not bear out, from the findings of a record."""
    return tuple(
        WithdrawnRole(d.headline, tuple(_figures(cause, d.headline) for cause in d.because))
        for d in diagnostics
        if d.code == "asset/role-withdrawn"
    )


def _row(suite: SuiteSection) -> SuiteRow:
    failed = next((check for check in suite.checks if not check.passed), None)
    astray = [_words(check.name.removeprefix("passes_at_")) for check in suite.repeats if not check.passed]
    repeats = _share([check.passed for check in suite.repeats])
    return SuiteRow(
        name=suite.name,
        outcome=suite.outcome.replace("_", " "),
        passed=sum(check.passed for check in suite.checks),
        of=len(suite.checks),
        why=suite.reason or ("" if failed is None else _failure(failed)),
        margins=_margins(suite),
        corners=_share([corner.passed for corner in suite.corners]),
        repeats=f"{repeats}, fails at {', '.join(astray)}" if astray else repeats,
    )


def _margins(suite: SuiteSection) -> tuple[str, ...]:
    limits = tuple(margin.statement for margin in suite.margins if margin.statement)
    if limits or not suite.margins or not all(corner.passed for corner in suite.corners):
        return limits
    return (f"holds within all bounds of {' and '.join(margin.word for margin in suite.margins)}",)


def _failure(check: Check) -> str:
    """Name (as on record: it may hold names of joints and places), value and bound of a check."""
    return f"{check.name}: {_quantity(check.value, check.unit)}, bound {_quantity(check.bound, check.unit)}"


def _figures(finding: Diagnostic, headline: str) -> str:
    """The finding with value and bound, without its own headline where `headline` holds it."""
    figures = [_quantity(figure, finding.unit) for figure in (finding.value, finding.bound) if figure is not None]
    return ": ".join(filter(None, ["" if finding.headline in headline else finding.headline, ", bound ".join(figures)]))


def _quantity(value: float | str | None, unit: str) -> str:
    text = f"{value:.3g}" if isinstance(value, (int, float)) else str(value)
    return f"{text} {unit}".rstrip()


def _share(passed: Sequence[bool]) -> str:
    return f"{sum(passed)} of {len(passed)}" if passed else ""


def _words(name: str) -> str:
    return name.replace("_", " ")
