"""Seeded defects: each one in a clean package is found by its rule, with its severity, and points at a prim."""

from __future__ import annotations

from pathlib import Path

import pytest

from gate import static_gate
from gate.static_gate import RULES, gate
from schemas.codes import CODES
from tests.suites.gate import DEFECTS, SOUND, Defect, Sound
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


@pytest.mark.parametrize("sound", SOUND, ids=lambda s: s.name)
def test_an_edit_that_is_no_defect_is_not_reported(sound: Sound, clean: dict[str, Path], tmp_path: Path) -> None:
    assert gate(seeded(sound.edit, clean[sound.package], tmp_path)) == ()


def test_the_packages_are_clean(clean: dict[str, Path]) -> None:
    assert {name: gate(file) for name, file in clean.items()} == {"prop": (), "cabinet": ()}


def test_every_rule_file_is_a_row_with_a_code_of_its_own() -> None:
    """A code that a rule declares has its page and its help by being in `RULES`."""
    folder = Path(static_gate.__file__).parent / "rules"
    files = [path.relative_to(folder) for path in folder.glob("*/*.py") if path.name != "__init__.py"]
    modules = {f"gate.rules.{'.'.join(path.with_suffix('').parts)}" for path in files}
    assert modules == {rule.check.__module__ for rule in RULES}
    assert {rule.code.name for rule in RULES}.isdisjoint(CODES)


def test_every_rule_has_a_defect() -> None:
    assert {defect.code for defect in DEFECTS} == {rule.code.name for rule in RULES}
    assert len({defect.name for defect in DEFECTS}) == len(DEFECTS)
