"""Recovery, the stage between interaction and physics: plausible materials on degraded surfaces, where wanted."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from assetkit.materials.normalize import appearance_section
from assetkit.materials.recovery.generator import Proposals, proposals, question_of
from assetkit.materials.recovery.library import LibraryMaterial
from assetkit.materials.recovery.pictures import draw
from assetkit.materials.recovery.recover import recover
from assetkit.materials.recovery.surfaces import OpenSurface, RecoverySubject
from assetkit.options import Options
from assetkit.package.preview_images import render_views
from assetkit.scale.declared_units import is_reliable
from assetkit.stage import Appearance, Canonical, Draft, Interaction, Recovery, Semantics, Stage, Tools
from jobs.cache import content_key
from schemas.appearance.record import RecoveredSurface
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Model
from schemas.outcome import ExternalAnswer, Outcome

_QUESTION_PX = 256  # of the pictures that a generator gets


class RecoverAppearance(Stage):
    """Fills in what degraded surfaces do not state. Trustworthy values stay; no other stage takes it for evidence."""

    name = "recovery"
    version = 1
    result = Recovery
    reads = (Canonical, Appearance, Semantics, Interaction)

    def wanted(self, options: Options) -> bool:
        """Whether the options want it."""
        return options.recover_appearance

    def run(self, draft: Draft, tools: Tools) -> Outcome[Recovery]:
        """Materials with what was filled in, and one finding for each degraded surface."""
        model, stated, subject = draft.model, draft[Appearance].section, subject_of(draft)
        answers: list[Proposals] = []
        generator = tools.options.generator

        def proposed(surfaces: Sequence[OpenSurface]) -> Sequence[Sequence[LibraryMaterial]]:
            if generator is None:
                return [()] * len(surfaces)
            question = question_of(surfaces, subject.category, subject.file_name, _views(model, tools.work_dir))
            answers.append(proposals(generator, question, len(surfaces), tools.work_dir))
            return answers[-1].of_surface

        recovered = recover(model, subject, partial(draw, work_dir=tools.work_dir), proposed)
        section, _ = appearance_section(recovered.model)
        # The colours of the record are those that the source states, and so are its degraded surfaces.
        kept = {"colours": stated.colours, "degraded": stated.degraded, "recovered": recovered.surfaces}
        indices = tuple(-1 if mesh.material is None else mesh.material for mesh in recovered.model.meshes)
        result = Recovery(recovered.model.materials, indices, section.model_copy(update=kept))
        notes = tuple(note for answer in answers for note in answer.findings)
        outside = [
            ExternalAnswer(
                content_key([entry.model_dump() for each in answer.of_surface for entry in each]), answer.use
            )
            for answer in answers
            if answer.use is not None
        ]
        findings = (*notes, *(_finding(surface) for surface in recovered.surfaces))
        return Outcome(result, findings, outside=outside[0] if outside else None)


def subject_of(draft: Draft) -> RecoverySubject:
    """What the draft holds on the object and its meshes beside their colours."""
    canonical, source = draft[Canonical], draft.intake.model
    per_m3 = canonical.meters_per_unit.value**-3
    densities = {path: mass.density * per_m3 for mass in source.masses if mass.density for path in mass.covers}
    contacts = {path: contact.name for contact in source.contacts for path in contact.covers}
    meshes = canonical.meshes
    return RecoverySubject(
        category=draft[Semantics].section.category,
        file_name=Path(draft.source_name).stem,
        folders=draft.intake.folders,
        parts=draft[Interaction].parts,
        is_metric=is_reliable(canonical.meters_per_unit, source.meters_per_unit),
        densities_kgm3={mesh.id: densities[mesh.source_path] for mesh in meshes if mesh.source_path in densities},
        contacts={mesh.id: contacts[mesh.source_path] for mesh in meshes if mesh.source_path in contacts},
    )


def _views(model: Model, work_dir: Path) -> dict[str, bytes]:
    points = np.concatenate([mesh.points for mesh in model.meshes])
    return render_views(model, (points.min(axis=0), points.max(axis=0)), work_dir, _QUESTION_PX)


def _finding(surface: RecoveredSurface) -> Diagnostic:
    family = surface.family
    headline = (
        f"{surface.reason}: {', '.join(surface.fields)} of '{surface.material}' are those of {surface.entry}, "
        f"{family.value} with confidence {family.confidence:.2f}"
    )
    where = Location(prim=surface.material)
    return finding("asset/appearance-recovered", headline, where=where, value=surface.entry)
