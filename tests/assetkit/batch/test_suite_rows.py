"""The table of suites in the report and what is printed of it: failed figures, margins, withdrawn roles, the video."""

from __future__ import annotations

import re

import pytest
from jinja2 import Environment, PackageLoader, StrictUndefined

from assetkit.batch.suite_rows import VIDEOS, suite_rows, withdrawn_roles
from assetkit.sources.discover import slug
from schemas.acceptance import Check, Corner, Margin, SuiteSection
from schemas.diagnostics import finding

GOOD = Check(name="fits", value=0.0, bound=1.0, unit="", passed=True)
BAD = Check(name="volume_0/leaves_most", value=0.31, bound=0.05, unit="m", passed=False)
FAILED = SuiteSection(name="receptacle", outcome="failed", checks=(GOOD, BAD, BAD.model_copy(update={"value": 9.0})))
UNRUN = SuiteSection(name="tool", outcome="not_run", reason="held by its base")
LOST = finding("asset/receptacle-leaves", "things leave <it>", value=0.31, bound=0.05, unit="m")


def margin(quantity: str, low: float, high: float) -> Margin:
    return Margin.model_validate({"quantity": quantity, "low": low, "high": high, "bounds": (0.2, 0.8)})


def passed(corners: tuple[bool, ...], *margins: Margin, repeats: tuple[Check, ...] = ()) -> SuiteSection:
    ends = tuple(Corner(friction=0.2, mass_kg=0.1, passed=ok) for ok in corners)
    return SuiteSection(
        name="manipulated", outcome="passed", checks=(GOOD,), repeats=repeats, corners=ends, margins=margins
    )


def page(**card: object) -> str:
    loader = PackageLoader("assetkit.batch", "templates")
    template = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("suites.html")
    return template.render(card={"suites": (), "withdrawn": (), "video": "", **card})


def test_a_failed_suite_shows_the_first_figure_that_failed_with_its_bound() -> None:
    (row,) = suite_rows([FAILED])
    assert (row.outcome, row.passed, row.of) == ("failed", 1, 3)
    assert row.why == "volume_0/leaves_most: 0.31 m, bound 0.05 m"
    assert row.remark == f"1 of 3 checks; {row.why}"
    assert row.why in page(suites=(row,))


def test_a_suite_that_was_not_run_shows_why() -> None:
    (row,) = suite_rows([UNRUN])
    assert (row.outcome, row.remark) == ("not run", "held by its base")
    assert "held by its base" in page(suites=(row,))


@pytest.mark.parametrize(
    ("suite", "said"),
    [
        (passed((True, False), margin("friction", 0.45, 0.8)), "1 of 1 checks; holds for friction >= 0.45"),
        (
            passed((True,) * 4, margin("friction", 0.2, 0.8), margin("mass_kg", 0.2, 0.8)),
            "1 of 1 checks; holds within all bounds of friction and mass",
        ),
        # Each alone holds over all of its bounds, both together do not: no margin may say that they do.
        (
            passed((True, True, True, False), margin("friction", 0.2, 0.8), margin("mass_kg", 0.2, 0.8)),
            "1 of 1 checks; 3 of 4 ends of friction and mass hold",
        ),
        (passed(()), "1 of 1 checks"),
    ],
)
def test_margins_say_how_far_a_suite_holds(suite: SuiteSection, said: str) -> None:
    (row,) = suite_rows([suite])
    assert row.remark == said
    assert all(words.replace(">", "&gt;") in page(suites=(row,)) for words in (*row.margins, row.corners))


def test_other_steps_at_which_a_suite_fails_are_named() -> None:
    rates = tuple(
        Check(name=f"passes_at_{rate}_hz", value=float(ok), bound=1.0, unit="", passed=ok)
        for rate, ok in ((120, False), (480, True))
    )
    (row,) = suite_rows([passed((), repeats=rates)])
    assert row.repeats == "1 of 2, fails at 120 hz"
    assert row.remark.endswith("steps of the engine: 1 of 2, fails at 120 hz")
    (row,) = suite_rows([passed((), repeats=rates[1:])])
    assert (row.repeats, row.remark) == ("1 of 1", "1 of 1 checks")


def test_a_withdrawn_role_stands_with_its_figures_and_says_nothing_twice() -> None:
    other = LOST.model_copy(update={"headline": "it tips"})
    taken = finding("asset/role-withdrawn", f"the role 'x' is not borne out: {LOST.headline}", because=(LOST, other))
    (role,) = withdrawn_roles([LOST, taken])
    assert role.figures == ("0.31 m, bound 0.05 m", "it tips: 0.31 m, bound 0.05 m")
    html = page(suites=suite_rows([FAILED]), withdrawn=(role,))
    assert "things leave &lt;it&gt; (0.31 m, bound 0.05 m; it tips" in html


def test_a_package_without_suites_has_no_table_and_a_video_is_linked() -> None:
    assert "<table>" not in page()
    assert 'href="videos/mug.gif"' in page(suites=suite_rows([FAILED]), video="videos/mug.gif")
    assert "href" not in page(suites=suite_rows([FAILED]))


def test_no_package_can_take_the_folder_of_videos() -> None:
    assert slug(VIDEOS) != VIDEOS
    assert not re.search(r"-([0-9a-f]{6}|\d+)$", VIDEOS)  # what follows the slug of namesakes and of parts
