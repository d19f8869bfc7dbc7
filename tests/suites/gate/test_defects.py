"""Seeded defects: each one in a clean package is found by its rule, with its severity, and points at a prim."""

from __future__ import annotations

from pathlib import Path

import pytest

from gate.static_gate import RULES, gate
from tests.suites.gate import DEFECTS, Defect
from tests.support.gate_packages import cabinet, prop, seeded


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("clean")
    return {"prop": prop(folder), "cabinet": cabinet(folder)}


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda d: d.name)
def test_each_defect_is_found_by_its_rule(defect: Defect, clean: dict[str, Path], tmp_path: Path) -> None:
    findings = gate(seeded(defect.edit, clean[defect.package], tmp_path))
    of_rule = [d for d in findings if d.code == defect.code]
    assert of_rule, [f"{d.code}: {d.headline}" for d in findings]
    assert max(of_rule, key=lambda d: d.severity == "error").severity == defect.severity
    assert all(d.headline and d.help for d in of_rule)
    assert "asset/internal-error" not in {d.code for d in findings}


def test_the_packages_are_clean(clean: dict[str, Path]) -> None:
    assert {name: gate(file) for name, file in clean.items()} == {"prop": (), "cabinet": ()}


def test_every_rule_has_a_defect() -> None:
    assert {defect.code for defect in DEFECTS} == {rule.code for rule in RULES}
    assert len({defect.name for defect in DEFECTS}) == len(DEFECTS)
