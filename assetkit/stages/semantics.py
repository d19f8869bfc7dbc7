"""Stage 4, semantics: what the object is. What the user says wins; else what names tell and the shape does not deny."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import numpy as np

from assetkit.annotate.annotator import UNKNOWN, Annotation, Annotator, Observation
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.name_reading import category_called
from assetkit.annotate.shape_check import compare, shape_of
from assetkit.options import Options
from assetkit.stage import Draft, Semantics, Stage, Tools, need
from assetkit.taxonomy.tables import OBJECT_QCODE, Category
from schemas.asset import CategoryHypothesis, SemanticsSection
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, default, inferred
from schemas.outcome import Outcome

_MAX_TEXTS = 60
_TITLES = ("title", "name")


class DescribeObject(Stage):
    """Category, family, roles and Wikidata class of the object, each with its evidence."""

    name = "semantics"
    version = 2
    result = Semantics
    annotator: Annotator = EmbeddedAnnotator()

    def run(self, draft: Draft, tools: Tools) -> Outcome[Semantics]:
        """The section; `review` when the category is unknown and the user wants to know it."""
        options, seen = tools.options, observe(draft)
        annotation = self.annotator.annotate(seen)
        category = _category(annotation, options, self.annotator.method)
        known = category_called(category.value)
        section = SemanticsSection(
            name=Path(draft.source_name).stem,
            category=category,
            family=_alike(category, known.family, "family of the category") if known else default(UNKNOWN),
            interaction_group=_alike(category, known.group, "how such things move") if known and known.group else None,
            roles=_roles(category, known, options),
            qcode=_qcode(category, known),
            hypotheses=tuple(
                CategoryHypothesis(category=h.category, score=h.score, clues=h.clues) for h in annotation.hypotheses
            ),
            source_texts=tuple(dict.fromkeys((seen.file, *seen.titles, *seen.nodes, *seen.materials)))[:_MAX_TEXTS],
        )
        doubtful = options.require_category and category.value == UNKNOWN
        return Outcome(Semantics(section), _findings(annotation, seen, known, options), review=doubtful)


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
        shape=shape_of(np.concatenate([mesh.points for mesh in canonical.meshes]), canonical.solid),
        shared=draft.intake.siblings > 0,
    )


def _category(annotation: Annotation, options: Options, method: str) -> Evidence[str]:
    if options.category:
        return declared(options.category, "--category")
    if annotation.category == UNKNOWN:
        return default(UNKNOWN, annotation.reason)
    return inferred(annotation.category, method, annotation.score, inputs=annotation.hypotheses[0].clues)


def _alike(category: Evidence[str], value: str, method: str) -> Evidence[str]:
    """What follows from the category, as sure as that is."""
    return inferred(value, method, category.confidence, inputs=(category.value,))


def _roles(category: Evidence[str], known: Category | None, options: Options) -> tuple[Evidence[str], ...]:
    if options.role:
        return (declared(options.role, "--role"),)
    return tuple(_alike(category, role, "usual role of the category") for role in (known.roles if known else ()))


def _qcode(category: Evidence[str], known: Category | None) -> Evidence[str]:
    if known is None or known.qcode_level == "object":
        return default(OBJECT_QCODE, "most general class")
    if known.qcode_level == "family":
        return _alike(category, known.qcode, f"Wikidata class of the family {known.family}, which is more general")
    return _alike(category, known.qcode, "Wikidata class of the category")


def _findings(
    annotation: Annotation, seen: Observation, known: Category | None, options: Options
) -> tuple[Diagnostic, ...]:
    if not options.category:
        contradicted = [finding("asset/category-contradicted", text) for text in annotation.contradictions]
        return (*contradicted, *([_unknown(annotation)] if annotation.category == UNKNOWN else []))
    if known is None:
        headline = f"'{options.category}' is no category of the vocabulary"
        return (finding("asset/category-outside-vocabulary", headline),)
    against = [f"stated {known.id}, but {f.text}" for f in compare(known, seen.shape) if f.leaves < 1.0]
    if annotation.category not in (UNKNOWN, known.id):
        against.append(f"stated {known.id}, but {annotation.hypotheses[0].clues[0]}")
    return tuple(finding("asset/category-contradicted", text) for text in against)


def _unknown(annotation: Annotation) -> Diagnostic:
    ranked = ", ".join(f"{h.category} {h.score:.2f}" for h in annotation.hypotheses[:3])
    return finding("asset/category-unknown", f"the category is unknown: {annotation.reason}", value=ranked or None)
