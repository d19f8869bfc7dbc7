"""The declared contact of body and support: keys of `subject.contact` as effects of the library."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any, cast

from schemas.diagnostics import Diagnostic, Location, finding
from schemas.measurement import MeasurementSpec, PairContact
from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange
from sim.effects.effect import Effect, Parameter
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR
from simgap.recording.reading.yaml_text import YamlDocument

FAMILY = "contact."
CONTACT_EFFECTS: Mapping[str, Effect] = {e.name.removeprefix(FAMILY): e for e in EFFECTS if e.name.startswith(FAMILY)}


def contact_findings(spec: MeasurementSpec, document: YamlDocument) -> tuple[Diagnostic, ...]:
    """Errors for keys that are no contact effect of this kind of measurement, and for values out of its bounds."""
    return tuple(
        diagnostic
        for key, given in spec.subject.contact.effects.items()
        for diagnostic in _key_findings(spec, key, given, document)
    )


def with_declared_contact(body: BodyModel, contact: PairContact) -> BodyModel:
    """The body with every effect that `contact` declares besides friction and restitution."""
    for key, given in contact.effects.items():
        effect = CONTACT_EFFECTS[key]
        assert isinstance(effect.hook, ModelChange)
        body = effect.hook.change(body, _parameters(effect, given), Place(pair=SUPPORT_PAIR))
    return body


def _parameters(effect: Effect, given: float | Mapping[str, float]) -> dict[str, float]:
    """Values by parameter name."""
    return dict(given) if isinstance(given, Mapping) else {effect.parameters[0].name: given}


def _key_findings(spec: MeasurementSpec, key: str, given: Any, document: YamlDocument) -> Iterator[Diagnostic]:
    path = ("subject", "contact", key)
    dotted = ".".join(path)
    effect = CONTACT_EFFECTS.get(key)
    if effect is None or spec.kind not in effect.kinds:
        known = [name for name, e in CONTACT_EFFECTS.items() if spec.kind in e.kinds]
        what = "is no contact effect" if effect is None else f"does not act on measurements of kind {spec.kind}"
        place = document.place(path, of_key=True)
        yield finding("gap/unknown-key", f"'{dotted}' {what}; {_hint(key, known)}", where=place)
        return
    names = [p.name for p in effect.parameters]
    if not isinstance(given, Mapping) and len(names) > 1:
        text = f"'{dotted}' has several parameters: give a mapping with {', '.join(names)}"
        yield finding("gap/invalid-value", text, where=document.place(path), value=str(given)[:60])
        return
    values = _parameters(effect, cast("float | Mapping[str, float]", given))
    for name in [n for n in values if n not in names]:
        text = f"'{dotted}.{name}' is no parameter of {effect.name}; {_hint(str(name), names)}"
        yield finding("gap/unknown-key", text, where=document.place((*path, name), of_key=True))
    for parameter in effect.parameters:
        if parameter.name not in values:
            yield finding("gap/missing-key", f"'{dotted}.{parameter.name}' is not given", where=document.place(path))
            continue
        place = document.place((*path, parameter.name) if isinstance(given, Mapping) else path)
        yield from _value_findings(dotted, parameter, values[parameter.name], place)


def _value_findings(dotted: str, parameter: Parameter, value: object, where: Location) -> Iterator[Diagnostic]:
    """An error for what is no number, or none within the bounds of the parameter."""
    low, high = parameter.low, parameter.high
    if isinstance(value, bool) or not isinstance(value, int | float):
        text = f"'{dotted}' takes a number for {parameter.name}"
        yield finding("gap/invalid-value", text, where=where, value=str(value)[:60])
    elif not low <= value <= high:
        text = f"'{dotted}' is {value:g}, plausible are {low:g} to {high:g}"
        bound = low if value < low else high
        yield finding("gap/invalid-value", text, where=where, value=value, bound=bound, unit=parameter.unit)


def _hint(name: str, known: list[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(known) or 'none'}"
