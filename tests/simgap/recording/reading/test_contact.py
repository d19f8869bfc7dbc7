"""`subject.contact` takes what contact effects of the library take; each value is simulated and is the null value."""

from __future__ import annotations

from pathlib import Path

import pytest

from cli.engines import REPLAY_ENGINE
from schemas.diagnostics import Diagnostic
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from simgap.case import case_of
from simgap.problem import Candidate
from simgap.recording.read import read
from tests.support.bad_inputs.gap import FREE, PUSH, flight, folder_of, pushed
from tests.support.measurements import sound

CONTACT = [e for e in EFFECTS if e.name.startswith("contact.")]
BESIDES = [e for e in CONTACT if e.name not in ("contact.friction", "contact.restitution")]
SUPPORT = "world: {support: {plane: {height_m: -50.0}}}\n"


def plausible(effect: Effect) -> dict[str, float]:
    """A value of each parameter that is not the one without effect."""
    return {p.name: 0.75 * p.low + 0.25 * p.high for p in effect.parameters}


def written(effect: Effect, values: dict[str, float]) -> str:
    """A number for one parameter, a mapping for several."""
    name = effect.name.removeprefix("contact.")
    only = len(values) == 1
    text = "".join(f"{v}" for v in values.values()) if only else ", ".join(f"{n}: {v}" for n, v in values.items())
    return f"  contact: {{{name}: {text if only else '{' + text + '}'}}}\n"


def tossed(folder: Path, contact: str) -> Path:
    return folder_of(folder, FREE + contact + SUPPORT, {f"t{k}": flight(k) for k in range(4)})


def pushes(folder: Path, contact: str) -> Path:
    spec = PUSH.replace("subject: {box: {size_m: [0.1, 0.1, 0.02]}, mass_kg: 1.0}\n", "subject:\n")
    spec += "  box: {size_m: [0.1, 0.1, 0.02]}\n  mass_kg: 1.0\n" + contact
    tables = {f"p{k}.{part}": table for k in range(4) for part, table in pushed(k).items()}
    return folder_of(folder, spec, tables)


def candidates(folder: Path) -> dict[str, Candidate]:
    case = case_of(sound(folder), REPLAY_ENGINE)
    return {c.effect.name: c for c in case.problem.candidates()}


@pytest.mark.parametrize("effect", [e for e in CONTACT if "free_body" in e.kinds], ids=lambda e: e.name)
def test_every_contact_effect_of_a_toss_can_be_declared(tmp_path: Path, effect: Effect):
    values = plausible(effect)
    found = candidates(tossed(tmp_path, written(effect, values)))
    assert found[effect.name].null == pytest.approx(values)


@pytest.mark.parametrize("effect", [e for e in BESIDES if "push" in e.kinds], ids=lambda e: e.name)
def test_every_contact_effect_of_a_push_can_be_declared(tmp_path: Path, effect: Effect):
    values = plausible(effect)
    found = candidates(pushes(tmp_path, written(effect, values)))
    assert found[effect.name].null == pytest.approx(values)


def test_a_mapping_of_one_parameter_is_its_number(tmp_path: Path):
    (as_mapping := tmp_path / "mapping").mkdir()
    found = candidates(tossed(as_mapping, "  contact: {rolling_friction: {lever_m: 0.002}}\n"))
    assert found["contact.rolling_friction"].null == {"lever_m": 0.002}


def refusals(folder: Path, contact: str) -> list[Diagnostic]:
    outcome = read(tossed(folder, contact))
    return [d for d in outcome.diagnostics if d.severity == "error"]


@pytest.mark.parametrize(
    ("contact", "code", "words"),
    [
        ("rolling_frictoin: 0.1", "gap/unknown-key", "did you mean 'rolling_friction'?"),
        ("compliance: 100", "gap/invalid-value", "stiffness_Npm, damping_Nspm"),
        ("compliance: {stiffness_Npm: 100}", "gap/missing-key", "compliance.damping_Nspm"),
        ("rolling_friction: {lever: 0.1, lever_m: 0.1}", "gap/unknown-key", "did you mean 'lever_m'?"),
        ("rolling_friction: 3.0", "gap/invalid-value", "0 to 0.1"),
        ("rolling_friction: soft", "gap/invalid-value", "rolling_friction"),
    ],
)
def test_what_no_effect_takes_is_refused_in_its_line(tmp_path: Path, contact: str, code: str, words: str):
    found = refusals(tmp_path, f"  contact: {{{contact}}}\n")
    assert {d.code for d in found} == {code}
    assert words in found[0].headline
    assert found[0].where.line == 8


def test_an_effect_of_another_kind_is_refused(tmp_path: Path):
    outcome = read(pushes(tmp_path, "  contact: {rolling_friction: 0.002}\n"))
    (found,) = [d for d in outcome.diagnostics if d.severity == "error"]
    assert (found.code, "kind push" in found.headline) == ("gap/unknown-key", True)
