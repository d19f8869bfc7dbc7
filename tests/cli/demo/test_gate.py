"""What the demo shows of the gate: every spoiled number is found, by the rule meant for it."""

from __future__ import annotations

from pathlib import Path

from cli.demo.gate import SPOILS, spoil_package
from schemas.diagnostics import Severity
from tests.support.gate_packages import prop

RULES = ("density", "inertia", "mass-centre-outside", "friction", "restitution", "no-collider")


def test_every_spoiled_number_is_an_error_of_its_rule(tmp_path: Path) -> None:
    package = prop(tmp_path).parent.parent
    before = {p: p.read_bytes() for p in package.rglob("*") if p.is_file()}
    spoiled = spoil_package(package)
    assert [s.what for s in spoiled] == [what for what, *_ in SPOILS]
    for one, rule in zip(spoiled, RULES, strict=True):
        assert f"asset/gate-{rule}" in {d.code for d in one.gate if d.severity is Severity.ERROR}, one.what
    assert {p: p.read_bytes() for p in package.rglob("*") if p.is_file()} == before
