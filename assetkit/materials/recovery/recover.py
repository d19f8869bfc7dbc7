"""Fills in the open values of degraded surfaces from the candidates with the highest scores; everything else stays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from assetkit.materials.recovery.families import FamilyChances, family_chances
from assetkit.materials.recovery.library import LibraryMaterial, library
from assetkit.materials.recovery.pictures import with_material_per_surface
from assetkit.materials.recovery.rank import Candidate, DrawnSurface, ranked, shortlist, with_picture
from assetkit.materials.recovery.surfaces import OpenSurface, RecoverySubject, open_surfaces
from schemas.appearance.material import Material, Origin
from schemas.appearance.record import RecoveredSurface, RecoveryCandidate
from schemas.evidence import Evidence
from schemas.model import Model

# Draws a model under variants of materials, regions given by material: [variant][region], None where nothing is seen.
Draw = Callable[[Model, Sequence[Sequence[Material]], Sequence[int]], list[list[DrawnSurface | None]]]
# Proposals of a generator for the surfaces, in their order; () where it has none.
Propose = Callable[[Sequence[OpenSurface]], Sequence[Sequence[LibraryMaterial]]]


class Choice(NamedTuple):
    """The candidates of one surface, best first, and the chances of its families."""

    surface: OpenSurface
    candidates: tuple[Candidate, ...]
    chances: FamilyChances

    @property
    def family(self) -> Evidence[str]:
        """The family of the best candidate with its confidence."""
        return self.chances.evidence(self.candidates[0].entry.family)


@dataclass(frozen=True)
class RecoveredModel:
    """The model with plausible materials on its degraded surfaces, and what was filled in."""

    model: Model
    surfaces: tuple[RecoveredSurface, ...] = ()


def recover(
    model: Model, subject: RecoverySubject, draw: Draw | None = None, propose: Propose | None = None
) -> RecoveredModel:
    """`model` with the open values of its degraded surfaces filled in; the same object where there are none.

    `draw` shows the candidates; without it they are ranked by what is known alone. `propose` adds candidates.
    """
    surfaces = open_surfaces(model, subject)
    if not surfaces:
        return RecoveredModel(model)
    proposals = propose(surfaces) if propose is not None else [()] * len(surfaces)
    choices = [_choice(surface, subject.category, more) for surface, more in zip(surfaces, proposals, strict=True)]
    if draw is not None:
        choices = _looked_at(model, choices, draw)
    return _filled_model(model, _agreed(choices))


def _choice(surface: OpenSurface, category: Evidence[str], proposals: Sequence[LibraryMaterial]) -> Choice:
    chances = family_chances(surface.clues, category)
    names = (*surface.clues.own_names, *surface.clues.of_whole[:1])
    listed = shortlist(chances, library(), surface.colour, names)
    proposed = tuple(c for entry in proposals for c in shortlist(chances, [entry], surface.colour, names))
    return Choice(surface, ranked((*listed, *proposed)), chances)


def _looked_at(model: Model, choices: Sequence[Choice], draw: Draw) -> list[Choice]:
    """The choices with the terms of their pictures; variant k shows the k-th candidate of every surface."""
    separate, indices = with_material_per_surface(
        model, [c.surface.meshes for c in choices], [c.surface.degraded.index for c in choices]
    )
    most = max(len(choice.candidates) for choice in choices)
    variants: list[Sequence[Material]] = []
    for k in range(most):
        materials = list(separate.materials)
        for index, choice in zip(indices, choices, strict=True):
            entry = choice.candidates[min(k, len(choice.candidates) - 1)].entry
            materials[index] = with_entry(materials[index], entry, choice.surface.degraded.fields, choice.family)
        variants.append(materials)
    seen = draw(separate, variants, indices)
    results: list[Choice] = []
    for number, choice in enumerate(choices):
        views = [seen[k][number] for k in range(len(choice.candidates))]
        looked = [
            candidate if drawn is None else with_picture(candidate, drawn, choice.surface.colour)
            for candidate, drawn in zip(choice.candidates, views, strict=True)
        ]
        results.append(choice._replace(candidates=ranked(looked)))
    return results


def _agreed(choices: Sequence[Choice]) -> list[Choice]:
    """The choices with one entry for surfaces of one degraded material whose best candidates are of one class.

    It is that with the highest sum of scores among those that all of them weighed: a tray is not chequered.
    """
    groups: dict[tuple[int | None, str, str | None], list[int]] = {}
    for number, choice in enumerate(choices):
        best = choice.candidates[0].entry.material_class
        groups.setdefault((choice.surface.degraded.index, best, choice.surface.colour), []).append(number)
    results = list(choices)
    for (_, of_class, _), members in groups.items():
        scores = [
            {c.entry.name: c.score for c in choices[m].candidates if c.entry.material_class == of_class}
            for m in members
        ]
        common = set(scores[0]).intersection(*scores)
        if len(members) > 1 and common:
            entry = max(common, key=lambda name: (round(sum(each[name] for each in scores), 6), name))
            for member in members:
                first = sorted(choices[member].candidates, key=lambda candidate: candidate.entry.name != entry)
                results[member] = choices[member]._replace(candidates=tuple(first))
    return results


def with_entry(
    material: Material, entry: LibraryMaterial, open_fields: Sequence[str], family: Evidence[str]
) -> Material:
    """`material` with its open fields from `entry`, as sure as the family; nothing else changes."""
    method = f"library entry {entry.name} ({entry.source}); {family.method}"
    origins = dict(material.origins)
    for name in open_fields:
        origins[name] = Origin(family.source, method, family.confidence)
    values = {name: getattr(entry, name) for name in open_fields}
    return replace(material, origins=origins, **values)


def _filled_model(model: Model, choices: Sequence[Choice]) -> RecoveredModel:
    materials = list(model.materials)
    chosen: dict[str, int] = {}
    records: list[RecoveredSurface] = []
    recovered = {mesh for choice in choices for mesh in choice.surface.meshes}
    in_use = {mesh.material for mesh in model.meshes if mesh.id not in recovered}
    index_of: dict[tuple[int | None, str], int] = {}
    for choice in choices:
        original, best = choice.surface.degraded.index, choice.candidates[0].entry
        key = (original, f"{best.name} {choice.family.confidence}")
        if key not in index_of:
            base = Material(f"recovered_{best.name}") if original is None else model.materials[original]
            filled = with_entry(base, best, choice.surface.degraded.fields, choice.family)
            if original is not None and original not in in_use:
                in_use.add(original)
                index_of[key], materials[original] = original, filled
            else:
                name = filled.name if original is None else f"{filled.name}_{best.name}"
                index_of[key] = len(materials)
                materials.append(replace(filled, name=_free(name, {m.name for m in materials})))
        chosen |= dict.fromkeys(choice.surface.meshes, index_of[key])
        records.append(_record(choice, materials[index_of[key]].name))
    meshes = tuple(replace(mesh, material=chosen.get(mesh.id, mesh.material)) for mesh in model.meshes)
    return RecoveredModel(replace(model, meshes=meshes, materials=tuple(materials)), tuple(records))


def _free(name: str, taken: set[str]) -> str:
    return next(each for each in (name, *(f"{name}_{i}" for i in range(2, len(taken) + 3))) if each not in taken)


def _record(choice: Choice, material: str) -> RecoveredSurface:
    best = choice.candidates[0].entry
    return RecoveredSurface(
        material=material,
        meshes=choice.surface.meshes,
        reason=choice.surface.degraded.reason,
        family=choice.family,
        entry=best.name,
        colour_basis=best.colour_basis,
        entry_source=best.source,
        licence=best.licence,
        fields=choice.surface.degraded.fields,
        candidates=tuple(
            RecoveryCandidate(entry=c.entry.name, family=c.entry.family, score=round(c.score, 3), terms=dict(c.terms))
            for c in choice.candidates
        ),
    )
