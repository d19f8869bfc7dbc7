"""An effect is one file: no other code of the packages names one, and estimators are named on both sides."""

from __future__ import annotations

import ast
import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.measurement import Kind
from sim.effects.candidacy import Candidacy
from sim.effects.effect import Effect
from sim.effects.library import EFFECT_NAMES, EFFECTS, RESERVED_NAMES
from simgap.kinds.free_body.direct_estimates import ESTIMATORS
from simgap.kinds.impact.direct_estimates import ESTIMATORS as IMPACT_ESTIMATORS
from simgap.kinds.linkage.direct_estimates import LINKED_ESTIMATORS
from simgap.kinds.push.direct_estimates import ESTIMATORS as PUSH_ESTIMATORS

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.parent.name for path in ROOT.glob("*/__init__.py") if path.parent.name != "tests")
LIBRARY = ROOT / "sim" / "effects"
NAMED = re.compile(rf"(?<![\w.])(?:{'|'.join(map(re.escape, (*EFFECT_NAMES, *RESERVED_NAMES)))})(?![\w.])")


def named_effects(source: str) -> list[tuple[int, str]]:
    """Line and name of every effect in a string of Python; sentences, which have blanks, are words for people."""
    constants = (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Constant))
    strings = [(n.lineno, n.value) for n in constants if isinstance(n.value, str) and " " not in n.value]
    return [(line, name) for line, text in strings for name in NAMED.findall(text)]


def files(package: str) -> Iterator[Path]:
    return (path for path in (ROOT / package).rglob("*.py") if LIBRARY not in path.parents)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_code_outside_the_library_names_an_effect(package: str) -> None:
    named = {path.relative_to(ROOT).as_posix(): named_effects(path.read_text()) for path in files(package)}
    assert {path: names for path, names in named.items() if names} == {}


def test_effects_in_code_are_found_and_words_for_people_are_not() -> None:
    assert named_effects('x = {"joint.spring": 1}\nif "contact.friction" in y: z = f"{a}@joint.backlash"') == [
        (1, "joint.spring"),
        (2, "contact.friction"),
        (2, "joint.backlash"),
    ]
    assert named_effects('"""See joint.spring."""\nx = Option(help="as joint.spring")\ny = "my.joint.spring"') == []


def candidacies(effect: Effect) -> dict[Kind, Candidacy]:
    return {"mechanism": effect.mechanism, "free_body": effect.free_body, "impact": effect.impact, "push": effect.push}


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_only_kinds_that_can_reveal_an_effect_say_how(effect: Effect) -> None:
    silent = [how for kind, how in candidacies(effect).items() if kind not in effect.kinds]
    assert all(how == type(how)() for how in silent)


def test_every_estimator_is_an_effects_and_every_effect_finds_its_own() -> None:
    tosses = {name for e in EFFECTS for name in e.free_body.direct}
    linked = {name for e in EFFECTS for name in e.free_body.linked_direct}
    assert tosses == set(ESTIMATORS)
    assert linked - set(ESTIMATORS) == set(LINKED_ESTIMATORS)
    assert {e.impact.direct for e in EFFECTS} - {""} == set(IMPACT_ESTIMATORS)
    assert {e.push.direct for e in EFFECTS} - {""} == set(PUSH_ESTIMATORS)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_an_effect_is_its_file(effect: Effect) -> None:
    family, _, name = effect.name.partition(".")
    assert f'name="{effect.name}"' in (LIBRARY / family / f"{name}.py").read_text()
    written = effect.export.package or effect.export.urdf_contact or effect.export.urdf_joint
    assert not written or effect.export.urdf
    assert {*effect.export.urdf_contact, *effect.export.urdf_joint} <= {p.name for p in effect.parameters}


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_a_stored_effect_is_its_name(effect: Effect) -> None:
    stored = pickle.dumps(effect)
    assert pickle.loads(stored) is effect
    assert len(stored) < 200
