"""Stage 5, interaction: parts with labels and materials, front, uses of joints, proposed anchors; asset frame."""

from __future__ import annotations

from dataclasses import replace

from assetkit.affordances.anchors import propose_anchors
from assetkit.articulation.grip_parts import label_grips
from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.articulation.link_anchors import cavities_of_links, propose_link_anchors
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
from schemas.mechanism import Mechanism
from schemas.outcome import Outcome


class ProposeParts(Stage):
    """Parts with their labels, in `review` where a role depends on a disputed one. Acceptance verifies the anchors."""

    name = "interaction"
    version = 15
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
        if canonical.mechanism is None:
            interaction = Interaction(parts, material, propose_anchors(canonical.solid, cavities), cavities)
        else:
            seen = Interaction(parts, material, cavities=cavities)
            interaction = _articulated(canonical, canonical.mechanism, seen, section.interaction_group)
        known_front = draft.frame.front if draft.frame is not None else None
        front = known_front or front_of(meshes, category, labelled, cavities)
        review = bool(disputed_parts(labelled, section.roles))
        return Outcome(replace(interaction, front=front), tuple(diagnostics), review=review)


def _articulated(
    canonical: Canonical, mechanism: Mechanism, seen: Interaction, usual_group: Evidence[str] | None
) -> Interaction:
    """The interaction of an articulated object: the uses of its joints, its grips named, and the anchors of its links.

    `usual_group` is that of things of its category.
    """
    item = ArticulatedObject(mechanism, canonical.links, canonical.meshes, seen.parts, usual_group)
    parts, uses = label_grips(seen.parts, joint_uses(item))
    cavities = cavities_of_links(canonical.links)
    anchors = propose_link_anchors(item, uses, cavities)
    return replace(seen, parts=parts, anchors=anchors, joint_uses=uses, link_cavities=cavities)


def _segmenter(options: Options) -> CommandSegmenter | None:
    stated = options.segmenter
    return None if stated is None else CommandSegmenter(stated.command, Limits(stated.seconds, SEGMENTER_MEMORY_MB))
