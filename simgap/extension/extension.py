"""Reads `extension.json` and turns its effects into terms of a model, for the same mechanism or another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import ValidationError

from schemas.diagnostics import InvalidInput, Location, finding
from schemas.sim_gap.extension import AppliedEffect, ModelExtension
from sim.effects.library import effect
from simgap.problem import Candidate, Model, Term


def read_extension(path: Path) -> ModelExtension:
    """The extension in a file. Raises InvalidInput when it is not one, FileNotFoundError when it is not there."""
    try:
        return ModelExtension.model_validate_json(path.read_bytes())
    except ValidationError as problem:
        first = problem.errors()[0]
        place = ".".join(str(p) for p in first["loc"])
        headline = f"{place}: {first['msg']}" if place else first["msg"]
        raise InvalidInput(finding("gap/invalid-extension", headline, where=Location(file=path.name))) from None


def terms_of(extension: ModelExtension) -> Model:
    """The effects as terms in their order.

    Raises InvalidInput for an effect that the library does not have and for parameters that are not the effect's.
    """
    return tuple(_term(each) for each in extension.effects)


def _term(applied: AppliedEffect) -> Term:
    try:
        known = effect(applied.name)
    except KeyError as unknown:
        raise InvalidInput(finding("gap/unknown-effect", str(unknown.args[0]))) from None
    values, null = applied.values(), known.null()
    if set(values) != set(null):
        headline = f"{applied.name} takes {', '.join(null)}; given are {', '.join(values) or 'none'}"
        raise InvalidInput(finding("gap/invalid-extension", headline))
    for parameter in known.parameters:
        value = values[parameter.name]
        if not np.isfinite(value):
            headline = f"{applied.name}: {parameter.name} is not a number"
            raise InvalidInput(finding("gap/invalid-extension", headline, unit=parameter.unit))
    bounds = {p.name: (p.low, p.high) for p in known.parameters}
    return Term(Candidate(known, applied.where, null, values, bounds), values)
