"""The semantics section of the record and its findings, from an annotation, the user's statements and the taxonomy.

What the user states wins; otherwise the category of the annotation gives family, roles and Wikidata class.
"""

from __future__ import annotations

from assetkit.annotate.annotator import UNKNOWN, Annotation, Observation
from assetkit.annotate.name_reading import category_by_name
from assetkit.annotate.shape_check import compare
from assetkit.annotate.weigh import MODEL_TRUST
from assetkit.options import Options
from assetkit.taxonomy.tables import OBJECT_QCODE, Category
from schemas.asset import CategoryHypothesis, EndpointAnswer, SemanticsSection, UprightHypothesis
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, default, inferred

_MAX_TEXTS = 60


def semantics_section(
    name: str,
    category: Evidence[str],
    annotation: Annotation,
    observation: Observation,
    options: Options,
    *,
    scale: Evidence[float] | None,
    upright: Evidence[tuple[float, float, float]],
    uprights: tuple[UprightHypothesis, ...],
) -> SemanticsSection:
    """The section of the object `name` of this `category`; `scale` in metres per unit, `upright` in source axes."""
    known = category_by_name(category.value)
    answer = annotation.endpoint_result.answer if annotation.endpoint_result else None
    texts = (observation.file, *observation.titles, *observation.nodes, *observation.materials)
    return SemanticsSection(
        name=name,
        category=category,
        family=_with_category_confidence(category, known.family, "family of the category")
        if known
        else default(UNKNOWN),
        interaction_group=_with_category_confidence(category, known.group, "how such things move")
        if known and known.group
        else None,
        roles=_roles(category, known, answer, options),
        qcode=_qcode(category, known),
        hypotheses=tuple(
            CategoryHypothesis(category=h.category, score=h.score, clues=h.clues) for h in annotation.hypotheses
        ),
        source_texts=tuple(dict.fromkeys(texts))[:_MAX_TEXTS],
        endpoint_answer=answer,
        scale=scale,
        upright=upright,
        uprights=uprights,
    )


def category_evidence(annotation: Annotation, options: Options) -> Evidence[str]:
    """The category that the user states, else that of the annotation, else `unknown` with the reason."""
    if options.category:
        known = category_by_name(options.category)
        return declared(known.id if known else options.category, options.origin("category"))
    if annotation.category == UNKNOWN:
        return default(UNKNOWN, annotation.reason)
    return inferred(annotation.category, annotation.method, annotation.score, inputs=annotation.hypotheses[0].clues)


def _with_category_confidence(category: Evidence[str], value: str, method: str) -> Evidence[str]:
    """What follows from the category, with the confidence of the category."""
    return inferred(value, method, category.confidence, inputs=(category.value,))


def _roles(
    category: Evidence[str], known: Category | None, answer: EndpointAnswer | None, options: Options
) -> tuple[Evidence[str], ...]:
    if options.role:
        return (declared(options.role, options.origin("role")),)
    usual = {
        role: _with_category_confidence(category, role, "usual role of the category")
        for role in (known.roles if known else ())
    }
    by_role = answer.roles if answer else {}
    others = (
        inferred(r, answer.method, MODEL_TRUST * chance) for r, chance in by_role.items() if answer and r not in usual
    )
    return (*usual.values(), *others)


def _qcode(category: Evidence[str], known: Category | None) -> Evidence[str]:
    if known is None or known.qcode_level == "object":
        return default(OBJECT_QCODE, "most general class")
    if known.qcode_level == "family":
        return _with_category_confidence(
            category, known.qcode, f"Wikidata class of the family {known.family}, which is more general"
        )
    return _with_category_confidence(category, known.qcode, "Wikidata class of the category")


def semantic_findings(
    annotation: Annotation, observation: Observation, known: Category | None, options: Options
) -> tuple[Diagnostic, ...]:
    """Findings of the endpoint, and where names, pictures, shape or the user's statement contradict each other."""
    endpoint = annotation.endpoint_result.findings if annotation.endpoint_result else ()
    if not options.category:
        contradicted = [finding("asset/category-contradicted", text) for text in annotation.contradictions]
        return (*endpoint, *contradicted, *([_unknown(annotation)] if annotation.category == UNKNOWN else []))
    if known is None:
        headline = f"'{options.category}' is no category of the vocabulary"
        return (*endpoint, finding("asset/category-outside-vocabulary", headline))
    against = [
        f"stated {known.id}, but {f.text}" for f in compare(known, observation.shape) if f.remaining_chance < 1.0
    ]
    if annotation.category not in (UNKNOWN, known.id):
        against.append(f"stated {known.id}, but {annotation.hypotheses[0].clues[0]}")
    return (*endpoint, *(finding("asset/category-contradicted", text) for text in against))


def _unknown(annotation: Annotation) -> Diagnostic:
    ranked = ", ".join(f"{h.category} {h.score:.2f}" for h in annotation.hypotheses[:3])
    return finding("asset/category-unknown", f"the category is unknown: {annotation.reason}", value=ranked or None)
