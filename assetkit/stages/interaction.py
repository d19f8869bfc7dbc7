"""Stage 5, interaction: parts with labels and materials, front, uses of joints, proposed anchors; asset frame."""

from __future__ import annotations

from assetkit.affordances.anchors import propose_anchors
from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.articulation.link_anchors import propose_link_anchors
from assetkit.materials.part_materials import part_materials
from assetkit.options import Options
from assetkit.parts.find import find_parts
from assetkit.parts.human_labels import dispute_findings, disputed_parts, outdated_regions, with_human_labels
from assetkit.parts.segmenter import SEGMENTER_MEMORY_MB, CommandSegmenter
from assetkit.pose.front import front_of
from assetkit.stage import Appearance, Canonical, Draft, Interaction, Semantics, Stage, Tools
from geom.features.cavities import find_cavities
from jobs.cell import Limits
from schemas.diagnostics import finding
from schemas.evidence import Evidence
from schemas.outcome import Outcome
from schemas.parts import Part


class ProposeParts(Stage):
    """Parts with their labels, in `review` where a role depends on a disputed one. Acceptance verifies the anchors."""

    name = "interaction"
    version = 13
    result = Interaction
    reads = (Canonical, Appearance, Semantics)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Interaction]:
        """Parts by source, material, connection and shape, labels where the category has a word; proposed anchors."""
        canonical = draft[Canonical]
        section = draft[Semantics].section
        category = section.category
        cavities = find_cavities(canonical.solid)
        meshes = draft.model.meshes_by_id
        segmenter = _segmenter(tools.options)
        proposed = find_parts(meshes, draft.model.materials, category, segmenter=segmenter, cavities=cavities)
        labelled = with_human_labels(proposed.parts, tools.options.decisions)
        diagnostics = dispute_findings(labelled)
        if gone := outdated_regions(proposed.parts, tools.options.decisions):
            diagnostics.append(
                finding("asset/decision-outdated", f"{', '.join(gone)}: no such region is a part any more")
            )
        if segmenter is not None and proposed.segmenter_problem:
            diagnostics.append(finding("asset/segmenter-failed", f"{segmenter.name}: {proposed.segmenter_problem}"))
        parts, material = part_materials(
            meshes, draft.model, labelled, category, draft.source_name, draft.intake.folders
        )
        articulated = _articulated(canonical, parts, section.interaction_group)
        uses = joint_uses(articulated) if articulated is not None else ()
        anchors = (
            propose_link_anchors(articulated, uses)
            if articulated is not None
            else propose_anchors(canonical.solid, cavities)
        )
        known_front = draft.frame.front if draft.frame is not None else None
        front = known_front or front_of(meshes, category, labelled, cavities)
        review = bool(disputed_parts(labelled, section.roles))
        return Outcome(Interaction(parts, material, anchors, cavities, front, uses), tuple(diagnostics), review=review)


def _articulated(
    canonical: Canonical, parts: tuple[Evidence[Part], ...], usual_group: Evidence[str] | None
) -> ArticulatedObject | None:
    """The object as the uses of its joints are read from it; None for a rigid one."""
    if canonical.mechanism is None:
        return None
    return ArticulatedObject(canonical.mechanism, canonical.links, canonical.meshes, parts, usual_group)


def _segmenter(options: Options) -> CommandSegmenter | None:
    stated = options.segmenter
    return None if stated is None else CommandSegmenter(stated.command, Limits(stated.seconds, SEGMENTER_MEMORY_MB))
