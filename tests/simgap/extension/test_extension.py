"""Model extensions are applied unchanged, or refused with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from schemas.diagnostics import InvalidInput
from schemas.sim_gap.extension import AppliedEffect, Estimate, ModelExtension, Place
from sim.effects.library import EFFECTS
from simgap.extension.extension import read_extension, terms_of


def extension(name: str, **values: float) -> ModelExtension:
    parameters = {n: Estimate(value=v, unit="", ci95=(v, v)) for n, v in values.items()}
    effects = (AppliedEffect(name=name, where=Place(joint="door"), parameters=parameters),)
    return ModelExtension(measurement="0" * 64, effects=effects)


def test_every_effect_of_the_library_survives_a_file(tmp_path: Path):
    for effect in EFFECTS:
        file = tmp_path / "extension.json"
        file.write_text(extension(effect.name, **effect.null()).model_dump_json())
        (term,) = terms_of(read_extension(file))
        assert term.candidate.effect is effect
        assert term.candidate.where == Place(joint="door")
        assert term.values == effect.null()


@pytest.mark.parametrize(
    ("given", "code"),
    [
        (extension("joint.magnetism", torque_Nm=1.0), "gap/unknown-effect"),
        (extension("joint.coulomb_friction", friction=1.0), "gap/invalid-extension"),
        (extension("joint.coulomb_friction"), "gap/invalid-extension"),
        (extension("joint.coulomb_friction", torque_Nm=float("nan")), "gap/invalid-extension"),
    ],
)
def test_what_the_library_does_not_have_is_refused(given: ModelExtension, code: str):
    with pytest.raises(InvalidInput) as refused:
        terms_of(given)
    assert refused.value.diagnostic.code == code


@pytest.mark.parametrize("text", ["", "[]", '{"effects": []}', '{"measurement": "x", "effects": [{"name": 3}]}'])
def test_a_file_that_is_no_extension_is_refused(text: str, tmp_path: Path):
    file = tmp_path / "extension.json"
    file.write_text(text)
    with pytest.raises(InvalidInput) as refused:
        read_extension(file)
    assert refused.value.diagnostic.code == "gap/invalid-extension"
