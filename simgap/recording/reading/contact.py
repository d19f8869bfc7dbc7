"""The declared contact of body and support: keys of `subject.contact` as effects of the library, checked and applied."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping

from schemas.diagnostics import Diagnostic, finding
from schemas.gap import Place
from schemas.measurement import MeasurementSpec, PairContact
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR
from simgap.recording.reading.yaml_text import YamlDocument

FAMILY = "contact."
CONTACT_EFFECTS: Mapping[str, Effect] = {e.name.removeprefix(FAMILY): e for e in EFFECTS if e.name.startswith(FAMILY)}


def contact_findings(spec: MeasurementSpec, document: YamlDocument) -> tuple[Diagnostic, ...]:
    """Errors for keys that are no contact effect of this kind of measurement, and for values out of its bounds."""
    return tuple(
        found
        for key, given in spec.subject.contact.effects.items()
        for found in _key_findings(spec, key, given, document)
    )


def with_declared_contact(body: BodyModel, contact: PairContact) -> BodyModel:
    """The body with every effect that `contact` declares besides friction and restitution."""
    for key, given in contact.effects.items():
        effect = CONTACT_EFFECTS[key]
        assert isinstance(effect.hook, ModelChange)
        body = effect.hook.change(body, _parameters(effect, given), Place(pair=SUPPORT_PAIR))
    return body


def _parameters(effect: Effect, given: float | dict[str, float]) -> dict[str, float]:
    return given if isinstance(given, dict) else {effect.parameters[0].name: given}


def _key_findings(
    spec: MeasurementSpec, key: str, given: float | dict[str, float], document: YamlDocument
) -> Iterator[Diagnostic]:
    path = ("subject", "contact", key)
    effect = CONTACT_EFFECTS.get(key)
    if effect is None or spec.kind not in effect.kinds:
        known = [name for name, e in CONTACT_EFFECTS.items() if spec.kind in e.kinds]
        what = "is no contact effect" if effect is None else f"does not act on measurements of kind {spec.kind}"
        text = f"'subject.contact.{key}' {what}; {_hint(key, known)}"
        yield finding("gap/unknown-key", text, where=document.place(path, of_key=True))
        return
    names = [p.name for p in effect.parameters]
    if not isinstance(given, dict) and len(names) > 1:
        text = f"'subject.contact.{key}' has several parameters: give a mapping with {', '.join(names)}"
        yield finding("gap/invalid-value", text, where=document.place(path), value=given)
        return
    values = _parameters(effect, given)
    for name in values.keys() - set(names):
        text = f"'subject.contact.{key}.{name}' is no parameter of {effect.name}; {_hint(name, names)}"
        yield finding("gap/unknown-key", text, where=document.place((*path, name), of_key=True))
    for parameter in effect.parameters:
        value = values.get(parameter.name)
        if value is None:
            text = f"'subject.contact.{key}.{parameter.name}' is not given"
            yield finding("gap/missing-key", text, where=document.place(path))
        elif not parameter.low <= value <= parameter.high:
            bound = parameter.low if value < parameter.low else parameter.high
            text = f"'subject.contact.{key}' is {value:g}, plausible are {parameter.low:g} to {parameter.high:g}"
            place = document.place((*path, parameter.name) if isinstance(given, dict) else path)
            yield finding("gap/invalid-value", text, where=place, value=value, bound=bound, unit=parameter.unit)


def _hint(name: str, known: list[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(known) or 'none'}"
