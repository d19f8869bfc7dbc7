"""Stage 5, interaction: parts and what they are made of, anchors as geometry proposes them; asset frame."""

from __future__ import annotations

from assetkit.anchors import propose_anchors
from assetkit.front import front_of
from assetkit.options import Options
from assetkit.part_materials import part_materials
from assetkit.parts.find import find_parts
from assetkit.parts.segmenter import MEMORY_MB, CommandSegmenter
from assetkit.stage import Canonical, Draft, Interaction, Stage, Tools, need
from geom.cavity import find_cavities
from jobs.cell import Limits
from schemas.diagnostics import finding
from schemas.outcome import Outcome
from usdio.write_meshes import mesh_prim_names


class ProposeParts(Stage):
    """Parts with their labels. Anchors wait for acceptance."""

    name = "interaction"
    version = 10
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
        told = [finding("asset/part-disputed", text) for text in found.disputes]
        if segmenter is not None and found.segmenter_problem:
            told.append(finding("asset/segmenter-failed", f"{segmenter.name}: {found.segmenter_problem}"))
        parts, material = part_materials(
            meshes, draft.model, found.parts, category, draft.source_name, draft.intake.folders
        )
        anchors = propose_anchors(canonical.solid, cavities)
        front = front_of(meshes, category, found.parts, cavities)
        return Outcome(Interaction(parts, material, anchors, cavities, front), tuple(told))


def _segmenter(options: Options) -> CommandSegmenter | None:
    stated = options.segmenter
    return None if stated is None else CommandSegmenter(stated.command, Limits(stated.seconds, MEMORY_MB))
