"""The annotator that needs no network: names propose a category, size and form confirm or contradict it.

Different words for a category (file, folder, title, nodes, materials) count as independent witnesses: the chance that
all of them are wrong is the product of theirs; the same word in two places counts once. Geometry alone never proposes
anything: too many things are boxes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from assetkit.annotate.annotator import MIN_SCORE, UNKNOWN, Annotation, CategoryScore, Observation, ranked_annotation
from assetkit.annotate.name_reading import NameReading, read_name
from assetkit.annotate.shape_check import compare
from assetkit.taxonomy.tables import categories

MAX_SCORE = 0.95
METHOD = "names and geometry against the taxonomy"
# Weight of a place, relative to the file's own name. A folder often holds many things; when the file has a name of its
# own the folder weighs less, and nothing when the file is another thing. Modelling tools name nodes arbitrarily.
TITLE, FOLDER, FOLDER_OF_NAMED, NODES, MATERIALS = 0.95, 0.85, 0.4, 0.7, 0.35
# Names of a file count for all objects in it together. In a file named otherwise, nodes name parts and other things.
SHARED, NODES_OF_OTHER = 0.5, 0.5
_MAX_NODE_NAMES = 200
# Default names of new objects in modelling tools.
_PRIMITIVES = frozenset(
    ("cube", "box", "sphere", "cylinder", "cone", "torus", "circle", "disc", "plane", "line", "pipe", "tube", "block")
)


class _NameEvidence(NamedTuple):
    """The evidence of one place: a category, the words for it, its strength, and the clue in words."""

    category: str
    words: str
    strength: float
    clue: str


class EmbeddedAnnotator:
    """Category by names, confirmed or contradicted by geometry; `unknown` when the evidence is weak."""

    def annotate(self, observation: Observation) -> Annotation:
        """Ranked hypotheses with their clues; the first one is accepted when it is likely and well ahead."""
        witnesses = tuple(_witnesses(observation))
        weighed = [
            _weighed(category, witnesses, observation) for category in dict.fromkeys(w.category for w in witnesses)
        ]
        weighed.sort(key=lambda pair: (-pair[0].score, pair[0].category))
        if not weighed:
            return Annotation(UNKNOWN, (), "no name speaks of a category", METHOD)
        contradictions = tuple(f"named {h.category}, but {text}" for h, against in weighed[:1] for text in against)
        return ranked_annotation([hypothesis for hypothesis, _ in weighed], METHOD, contradictions)


def _weighed(
    category: str, witnesses: Sequence[_NameEvidence], observation: Observation
) -> tuple[CategoryScore, tuple[str, ...]]:
    """The hypothesis with its clues, and the contradictions by shape where the names alone would be accepted."""
    strongest: dict[str, _NameEvidence] = {}
    for witness in (w for w in witnesses if w.category == category):
        strongest[witness.words] = max(strongest.get(witness.words, witness), witness, key=lambda w: w.strength)
    clues = [witness.clue for witness in strongest.values()]
    wrong = math.prod(1.0 - witness.strength for witness in strongest.values())
    findings = compare(categories()[category], observation.shape)
    named = score = 1.0 - wrong
    against = tuple(f.text for f in findings if f.remaining_chance < 1.0)
    for finding in findings:  # What fits confirms nothing while something else does not.
        score = score * finding.remaining_chance if against else 1.0 - (1.0 - score) * (1.0 - finding.confirms)
    clues += [f.text for f in findings if f.remaining_chance == 1.0] + [f"against it: {text}" for text in against]
    return CategoryScore(category, round(min(score, MAX_SCORE), 3), tuple(clues)), against if named > MIN_SCORE else ()


def _witnesses(observation: Observation) -> Iterator[_NameEvidence]:
    file, whole = read_name(observation.file), SHARED if observation.shared else 1.0
    yield from _named("file", observation.file, file, whole)
    for title in observation.titles[:1]:
        yield from _named("title", title, read_name(title), whole * TITLE)
    if not file.other:
        weight = whole * FOLDER if file.is_uninformative else whole * FOLDER_OF_NAMED
        folder = next(((f, r) for f in observation.folders if not (r := read_name(f)).is_uninformative), None)
        if folder is not None:
            yield from _named("folder", *folder, weight)
    within = NODES_OF_OTHER if file.other else 1.0
    # Links are parts: the pans of a balance make it no frying pan, the drawers of a drawer unit confirm its name.
    if not (observation.articulated and file.other):
        nodes = [n for n in observation.nodes if n not in (observation.file, *observation.titles)]
        yield from _agreed("node", nodes, within * NODES)
    yield from _agreed("material", observation.materials, within * MATERIALS)


def _named(place: str, name: str, reading: NameReading, weight: float) -> Iterator[_NameEvidence]:
    if reading.category is not None:
        clue = f"{place} name '{name}' speaks of '{reading.words}'"
        yield _NameEvidence(reading.category, reading.words, weight * reading.strength, clue)


def _agreed(place: str, names: Iterable[str], weight: float) -> Iterator[_NameEvidence]:
    """The evidence of several names together: each category by its share among the things named."""
    chosen = [n for n in dict.fromkeys(names) if n.lower().rstrip("_.0123456789") not in _PRIMITIVES][:_MAX_NODE_NAMES]
    read = [(name, read_name(name)) for name in chosen]
    telling = [(name, reading) for name, reading in read if reading.category or reading.other]
    for category in dict.fromkeys(r.category for _, r in telling if r.category):
        parts = categories()[category].parts
        same = [(name, r) for name, r in telling if r.category == category]
        others = [r for _, r in telling if r.category != category and not set(r.other.split()) & set(parts)]
        name, reading = max(same, key=lambda pair: pair[1].strength)
        share = len(same) / (len(same) + len(others))
        clue = f"{place} name '{name}' speaks of '{reading.words}'"
        yield _NameEvidence(category, reading.words, weight * share * reading.strength, clue)
