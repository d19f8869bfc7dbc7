"""Stage 4, semantics: category, roles, scale and way up of the object.

The user's statements win; else the names and pictures that the shape does not contradict.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from assetkit.annotate.annotator import UNKNOWN, Annotation, Annotator
from assetkit.annotate.domain import out_of_domain
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.exchange import Post, Reply, exchange_in_cell
from assetkit.annotate.multimodal import MultimodalAnnotator
from assetkit.annotate.name_reading import category_by_name
from assetkit.annotate.observe import observe
from assetkit.annotate.semantics_section import category_evidence, semantic_findings, semantics_section
from assetkit.geometry.reference_frame import reference_frame
from assetkit.package.preview_images import render_previews
from assetkit.stage import Appearance, Canonical, Draft, Semantics, Stage, Tools
from jobs.cache import content_key
from render.camera import STANDARD_VIEWS
from schemas.diagnostics import finding
from schemas.outcome import ExternalAnswer, Outcome


class DescribeObject(Stage):
    """Category, family, roles and Wikidata class of the object, scale and way up, each with its evidence."""

    name = "semantics"
    version = 7
    result = Semantics
    reads = (Canonical, Appearance)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Semantics]:
        """The section; `review` for what Mana does not prepare, when an unknown category is not enough for the user,
        or pictures are contradicted.
        """
        options, observation = tools.options, observe(draft)
        if options.endpoint is not None:
            observation = replace(observation, views=_views(draft, tools))
        annotation = _annotator(tools).annotate(observation)
        category = category_evidence(annotation, options)
        known = category_by_name(category.value)
        frame = reference_frame(draft, known, observation.shape.extents_m, options)
        section = semantics_section(
            Path(draft.source_name).stem,
            category,
            annotation,
            observation,
            options,
            scale=frame.scale,
            upright=frame.upright,
            uprights=frame.hypotheses,
        )
        domain = "" if options.category or options.role else out_of_domain(observation, annotation)
        doubtful = bool(domain) or (options.require_category and category.value == UNKNOWN)
        disputed = annotation.disputed and not options.category
        screened = [finding("asset/out-of-domain", domain)] if domain else []
        findings = (*semantic_findings(annotation, observation, known, options), *screened, *frame.findings)
        return Outcome(
            Semantics(section, frame.frame), findings, review=doubtful or disputed, outside=_outside(annotation)
        )


def _annotator(tools: Tools) -> Annotator:
    embedded = EmbeddedAnnotator()
    if tools.options.endpoint is None:
        return embedded
    send = _unsent if tools.endpoint_lost else partial(exchange_in_cell, work_dir=tools.work_dir)
    return MultimodalAnnotator(tools.options.endpoint, embedded, send, tools.answers)


def _unsent(post: Post) -> Reply:
    return Reply(failure="out of reach for another object of this file, so not asked again")


def _views(draft: Draft, tools: Tools) -> dict[str, bytes]:
    """The four standard views, as previews will show them."""
    pictures = render_previews(draft.model, (), tools.work_dir)
    return {view.name: pictures[view.name] for view in STANDARD_VIEWS}


def _outside(annotation: Annotation) -> ExternalAnswer | None:
    if annotation.endpoint_result is None:
        return None
    answer = annotation.endpoint_result.answer
    return ExternalAnswer(content_key(answer.model_dump() if answer else None), annotation.endpoint_result.use)
