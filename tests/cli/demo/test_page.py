"""Sections of the page of the demo that may be absent do not take others along."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, nodes

import cli.demo
from assetkit.batch.suite_rows import suite_rows
from cli.demo.acceptance import AcceptanceDemo
from schemas.acceptance import Check, Margin, SuiteSection

TEMPLATE = Path(cli.demo.__file__).parent / "templates" / "demo.html"
OPTIONAL = {"scene", "mechanism", "accepted", "replay", "tasks"}  # arguments of `write_page` that may be None or empty


def sections() -> dict[str, nodes.If]:
    """The block of the template that each of them decides on."""
    parsed = Environment(autoescape=True).parse(TEMPLATE.read_text())
    return {block.test.name: block for block in parsed.find_all(nodes.If) if isinstance(block.test, nodes.Name)}


def test_a_section_that_is_absent_takes_no_other_along() -> None:
    blocks = sections()
    assert set(blocks) >= OPTIONAL
    inner = {
        name: {n.name for n in block.find_all(nodes.Name)} & OPTIONAL - {name}
        for name, block in blocks.items()
        if name in OPTIONAL
    }
    assert inner == {name: set() for name in OPTIONAL}


def test_acceptance_shows_margins_and_films_and_needs_no_scene() -> None:
    check = Check(name="held", value=1.0, bound=1.0, unit="", passed=True)
    margin = Margin(quantity="friction", low=0.45, high=0.8, bounds=(0.3, 0.8))
    rows = suite_rows([SuiteSection(name="manipulated", outcome="passed", checks=(check,), margins=(margin,))])
    loader = PackageLoader("cli.demo", "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("acceptance.html")
    mug, box = AcceptanceDemo("mug", rows, "videos/mug.gif"), AcceptanceDemo("box", (), "")
    html = page.render(accepted=(mug, box))
    assert "holds for friction &gt;= 0.45" in html
    assert html.count("<img") == 1
    assert 'src="videos/mug.gif"' in html
    assert "<b>box</b>" in html
