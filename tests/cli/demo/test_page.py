"""Sections of the page of the demo that may be absent do not take others along."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, nodes

import cli.demo

TEMPLATE = Path(cli.demo.__file__).parent / "templates" / "demo.html"
OPTIONAL = {"scene", "mechanism", "replay"}  # arguments of `write_page` that may be None


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
