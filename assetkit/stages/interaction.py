"""Stage 5, interaction: parts and what they are made of, anchors as geometry proposes them; asset frame."""

from __future__ import annotations

from collections.abc import Sequence

from assetkit.affordances.anchors import propose_anchors
from assetkit.materials.part_materials import part_materials
from assetkit.options import Options
from assetkit.parts.decided import in_doubt, lost, with_decided
from assetkit.parts.find import find_parts
from assetkit.parts.segmenter import MEMORY_MB, CommandSegmenter
from assetkit.pose.front import front_of
from assetkit.stage import Canonical, Draft, Interaction, Stage, Tools, need
from geom.features.cavities import find_cavities
from jobs.cell import Limits
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.outcome import Outcome
from schemas.parts import Part
from usdio.write.meshes import mesh_prim_names


class ProposeParts(Stage):
    """Parts with their labels, in `review` where a role depends on one in dispute. Anchors wait for acceptance."""

    name = "interaction"
    version = 12
    result = Interaction

    def run(self, draft: Draft, tools: Tools) -> Outcome[Interaction]:
        """Parts by source, material, connection and shape, labels where the category has a word; proposed anchors."""
        canonical: Canonical = need(draft.canonicalize, "canonicalize")
        section = need(draft.semantics, "semantics").section
        category = section.category
        cavities = find_cavities(canonical.solid)
        meshes = dict(zip(mesh_prim_names(draft.model), canonical.meshes, strict=True))
        segmenter = _segmenter(tools.options)
        found = find_parts(meshes, draft.model.materials, category, segmenter=segmenter, cavities=cavities)
        known = with_decided(found.parts, tools.options.decisions)
        told = _disputes(known)
        if gone := lost(found.parts, tools.options.decisions):
            told.append(finding("asset/decision-outdated", f"{', '.join(gone)}: no such region is a part any more"))
        if segmenter is not None and found.segmenter_problem:
            told.append(finding("asset/segmenter-failed", f"{segmenter.name}: {found.segmenter_problem}"))
        parts, material = part_materials(meshes, draft.model, known, category, draft.source_name, draft.intake.folders)
        anchors = propose_anchors(canonical.solid, cavities)
        told_before = draft.frame.front if draft.frame is not None else None
        front = told_before or front_of(meshes, category, known, cavities)
        review = bool(in_doubt(known, section.roles))
        return Outcome(Interaction(parts, material, anchors, cavities, front), tuple(told), review=review)


def _disputes(parts: Sequence[Evidence[Part]]) -> list[Diagnostic]:
    """One warning for each contradiction, with all parts that it leaves without a label."""
    texts: dict[str, list[Part]] = {}
    for part in (p.value for p in parts if p.value.may_be):
        texts.setdefault(part.label.method, []).append(part)
    who = {text: " and ".join(_either(p) for p in own) for text, own in texts.items()}
    return [finding("asset/part-disputed", f"{parts_of}: {text}") for text, parts_of in who.items()]


def _either(part: Part) -> str:
    return f"{part.part_id} ({' or '.join(part.may_be)})"


def _segmenter(options: Options) -> CommandSegmenter | None:
    stated = options.segmenter
    return None if stated is None else CommandSegmenter(stated.command, Limits(stated.seconds, MEMORY_MB))
