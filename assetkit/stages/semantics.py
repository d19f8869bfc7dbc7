"""Stage 4, semantics: what the object is. What the user says wins; else what names tell and the shape does not deny."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path, PurePosixPath

import numpy as np

from assetkit.annotate.annotator import UNKNOWN, Annotation, Annotator, Observation
from assetkit.annotate.domain import out_of_domain
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.exchange import Post, Reply, exchange_in_cell
from assetkit.annotate.multimodal import MultimodalAnnotator
from assetkit.annotate.name_reading import category_called
from assetkit.annotate.shape_check import compare, shape_of
from assetkit.annotate.weigh import SEEN
from assetkit.geometry.reference_frame import reference_frame
from assetkit.options import Options
from assetkit.scale.declared_units import is_reliable
from assetkit.stage import Draft, Semantics, Stage, Tools, need
from assetkit.stages.previews import render
from assetkit.taxonomy.tables import OBJECT_QCODE, Category
from jobs.cache import content_key
from render.camera import STANDARD_VIEWS
from schemas.asset import CategoryHypothesis, EndpointAnswer, SemanticsSection
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, default, inferred
from schemas.outcome import Outcome, Outside

_MAX_TEXTS = 60
_TITLES = ("title", "name")


class DescribeObject(Stage):
    """Category, family, roles and Wikidata class of the object, scale and way up, each with its evidence."""

    name = "semantics"
    version = 6
    result = Semantics

    def run(self, draft: Draft, tools: Tools) -> Outcome[Semantics]:
        """The section; `review` for what Mana does not prepare, when an unknown category is not enough for the user,
        or pictures are contradicted.
        """
        options, seen = tools.options, observe(draft)
        if options.endpoint is not None:
            seen = replace(seen, views=_views(draft, tools))
        annotation = _annotator(tools).annotate(seen)
        answer = annotation.asked.answer if annotation.asked else None
        category = _category(annotation, options)
        known = category_called(category.value)
        grounded = reference_frame(draft, known, seen.shape.extents_m, options)
        section = SemanticsSection(
            name=Path(draft.source_name).stem,
            category=category,
            family=_alike(category, known.family, "family of the category") if known else default(UNKNOWN),
            interaction_group=_alike(category, known.group, "how such things move") if known and known.group else None,
            roles=_roles(category, known, answer, options),
            qcode=_qcode(category, known),
            hypotheses=tuple(
                CategoryHypothesis(category=h.category, score=h.score, clues=h.clues) for h in annotation.hypotheses
            ),
            source_texts=tuple(dict.fromkeys((seen.file, *seen.titles, *seen.nodes, *seen.materials)))[:_MAX_TEXTS],
            endpoint_answer=answer,
            scale=grounded.scale,
            upright=grounded.upright,
            uprights=grounded.hypotheses,
        )
        outside = "" if options.category or options.role else out_of_domain(seen, annotation)
        doubtful = bool(outside) or (options.require_category and category.value == UNKNOWN)
        disputed = annotation.disputed and not options.category
        screened = [finding("asset/out-of-domain", outside)] if outside else []
        findings = (*_findings(annotation, seen, known, options), *screened, *grounded.doubts)
        return Outcome(
            Semantics(section, grounded.frame), findings, review=doubtful or disputed, outside=_outside(annotation)
        )


def observe(draft: Draft) -> Observation:
    """What an annotator is shown of a canonical object."""
    canonical, model = need(draft.canonicalize, "canonicalize"), draft.model
    paths = [mesh.source_path for mesh in canonical.meshes]
    nodes = (*(part for path in paths for part in PurePosixPath(path).parts), *(mesh.name for mesh in canonical.meshes))
    return Observation(
        file=Path(draft.source_name).stem,
        folders=draft.intake.folders,
        nodes=tuple(dict.fromkeys(name for name in nodes if name.strip("/"))),
        materials=tuple(dict.fromkeys(m.name for m in model.materials if m.name)),
        titles=tuple(model.metadata[key] for key in _TITLES if model.metadata.get(key)),
        shape=shape_of(
            np.concatenate([mesh.points for mesh in canonical.meshes]),
            canonical.solid,
            metric=is_reliable(canonical.meters_per_unit, model.meters_per_unit),
        ),
        shared=draft.intake.siblings > 0,
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
    pictures = render(draft.model, (), tools.work_dir)
    return {view.name: pictures[view.name] for view in STANDARD_VIEWS}


def _outside(annotation: Annotation) -> Outside | None:
    if annotation.asked is None:
        return None
    answer = annotation.asked.answer
    return Outside(content_key(answer.model_dump() if answer else None), annotation.asked.use)


def _category(annotation: Annotation, options: Options) -> Evidence[str]:
    if options.category:
        known = category_called(options.category)
        return declared(known.id if known else options.category, options.origin("category"))
    if annotation.category == UNKNOWN:
        return default(UNKNOWN, annotation.reason)
    return inferred(annotation.category, annotation.method, annotation.score, inputs=annotation.hypotheses[0].clues)


def _alike(category: Evidence[str], value: str, method: str) -> Evidence[str]:
    """What follows from the category, as sure as that is."""
    return inferred(value, method, category.confidence, inputs=(category.value,))


def _roles(
    category: Evidence[str], known: Category | None, answer: EndpointAnswer | None, options: Options
) -> tuple[Evidence[str], ...]:
    if options.role:
        return (declared(options.role, options.origin("role")),)
    usual = {role: _alike(category, role, "usual role of the category") for role in (known.roles if known else ())}
    seen = answer.roles if answer else {}
    others = (inferred(r, answer.method, SEEN * chance) for r, chance in seen.items() if answer and r not in usual)
    return (*usual.values(), *others)


def _qcode(category: Evidence[str], known: Category | None) -> Evidence[str]:
    if known is None or known.qcode_level == "object":
        return default(OBJECT_QCODE, "most general class")
    if known.qcode_level == "family":
        return _alike(category, known.qcode, f"Wikidata class of the family {known.family}, which is more general")
    return _alike(category, known.qcode, "Wikidata class of the category")


def _findings(
    annotation: Annotation, seen: Observation, known: Category | None, options: Options
) -> tuple[Diagnostic, ...]:
    asked = annotation.asked.findings if annotation.asked else ()
    if not options.category:
        contradicted = [finding("asset/category-contradicted", text) for text in annotation.contradictions]
        return (*asked, *contradicted, *([_unknown(annotation)] if annotation.category == UNKNOWN else []))
    if known is None:
        headline = f"'{options.category}' is no category of the vocabulary"
        return (*asked, finding("asset/category-outside-vocabulary", headline))
    against = [f"stated {known.id}, but {f.text}" for f in compare(known, seen.shape) if f.leaves < 1.0]
    if annotation.category not in (UNKNOWN, known.id):
        against.append(f"stated {known.id}, but {annotation.hypotheses[0].clues[0]}")
    return (*asked, *(finding("asset/category-contradicted", text) for text in against))


def _unknown(annotation: Annotation) -> Diagnostic:
    ranked = ", ".join(f"{h.category} {h.score:.2f}" for h in annotation.hypotheses[:3])
    return finding("asset/category-unknown", f"the category is unknown: {annotation.reason}", value=ranked or None)
