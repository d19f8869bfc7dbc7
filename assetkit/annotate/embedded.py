"""The annotator that needs no network: names propose a category, size and form confirm or contradict it.

Different words for a category (file, folder, title, nodes, materials) count as independent witnesses: the chance that
all of them are wrong is the product of theirs; the same word said twice counts once. Geometry alone never proposes
anything: too many things are boxes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from assetkit.annotate.annotator import STANDS, UNKNOWN, Annotation, Hypothesis, Observation, decided
from assetkit.annotate.name_reading import Reading, read_name
from assetkit.annotate.shape_check import compare
from assetkit.taxonomy.tables import categories

SUREST = 0.95
METHOD = "names and geometry against the taxonomy"
# How far a place is believed, against the file's own name. A folder often holds many things; when the file has a name
# of its own it says less, and nothing when the file is another thing. Modelling tools name nodes as they like.
TITLE, FOLDER, FOLDER_OF_NAMED, NODES, MATERIALS = 0.95, 0.85, 0.4, 0.7, 0.35
# Names of a file speak of all objects in it together. In a file named otherwise, nodes name parts and company.
SHARED, NODES_OF_OTHER = 0.5, 0.5
_MAX_NODES = 200
# What modelling tools call a new object, whatever it is to become.
_PRIMITIVES = frozenset(
    ("cube", "box", "sphere", "cylinder", "cone", "torus", "circle", "disc", "plane", "line", "pipe", "tube", "block")
)


class _Witness(NamedTuple):
    """What one place says: a category, by which words, how much that counts, and the clue in words."""

    category: str
    words: str
    strength: float
    clue: str


class EmbeddedAnnotator:
    """Names, confirmed or contradicted by geometry; says `unknown` when the evidence is thin or contradictory."""

    def annotate(self, observation: Observation) -> Annotation:
        """Ranked hypotheses with their clues; the first one stands when it is likely and has no rival."""
        witnesses = tuple(_witnesses(observation))
        found = [
            _weighed(category, witnesses, observation) for category in dict.fromkeys(w.category for w in witnesses)
        ]
        found.sort(key=lambda pair: (-pair[0].score, pair[0].category))
        if not found:
            return Annotation(UNKNOWN, (), "no name speaks of a category", METHOD)
        contradictions = tuple(f"named {h.category}, but {text}" for h, against in found[:1] for text in against)
        return decided([hypothesis for hypothesis, _ in found], METHOD, contradictions)


def _weighed(
    category: str, witnesses: Sequence[_Witness], observation: Observation
) -> tuple[Hypothesis, tuple[str, ...]]:
    """The hypothesis with its clues, and what of the shape speaks against it although the names alone would stand."""
    strongest: dict[str, _Witness] = {}
    for witness in (w for w in witnesses if w.category == category):
        strongest[witness.words] = max(strongest.get(witness.words, witness), witness, key=lambda w: w.strength)
    clues = [witness.clue for witness in strongest.values()]
    wrong = math.prod(1.0 - witness.strength for witness in strongest.values())
    findings = compare(categories()[category], observation.shape)
    named = score = 1.0 - wrong
    against = tuple(f.text for f in findings if f.leaves < 1.0)
    for finding in findings:  # What fits confirms nothing while something else does not.
        score = score * finding.leaves if against else 1.0 - (1.0 - score) * (1.0 - finding.confirms)
    clues += [f.text for f in findings if f.leaves == 1.0] + [f"against it: {text}" for text in against]
    return Hypothesis(category, round(min(score, SUREST), 3), tuple(clues)), against if named > STANDS else ()


def _witnesses(seen: Observation) -> Iterator[_Witness]:
    file, whole = read_name(seen.file), SHARED if seen.shared else 1.0
    yield from _named("file", seen.file, file, whole)
    for title in seen.titles[:1]:
        yield from _named("title", title, read_name(title), whole * TITLE)
    if not file.other:
        believed = whole * FOLDER if file.silent else whole * FOLDER_OF_NAMED
        folder = next(((f, r) for f in seen.folders if not (r := read_name(f)).silent), None)
        if folder is not None:
            yield from _named("folder", *folder, believed)
    within = NODES_OF_OTHER if file.other else 1.0
    yield from _agreed("node", [n for n in seen.nodes if n not in (seen.file, *seen.titles)], within * NODES)
    yield from _agreed("material", seen.materials, within * MATERIALS)


def _named(place: str, name: str, reading: Reading, believed: float) -> Iterator[_Witness]:
    if reading.category is not None:
        clue = f"{place} name '{name}' speaks of '{reading.words}'"
        yield _Witness(reading.category, reading.words, believed * reading.strength, clue)


def _agreed(place: str, names: Iterable[str], believed: float) -> Iterator[_Witness]:
    """What several names say together: each category as far as no other thing is named that is none of its parts."""
    chosen = [n for n in dict.fromkeys(names) if n.lower().rstrip("_.0123456789") not in _PRIMITIVES][:_MAX_NODES]
    read = [(name, read_name(name)) for name in chosen]
    telling = [(name, reading) for name, reading in read if reading.category or reading.other]
    for category in dict.fromkeys(r.category for _, r in telling if r.category):
        parts = categories()[category].parts
        same = [(name, r) for name, r in telling if r.category == category]
        others = [r for _, r in telling if r.category != category and not set(r.other.split()) & set(parts)]
        name, reading = max(same, key=lambda pair: pair[1].strength)
        share = len(same) / (len(same) + len(others))
        clue = f"{place} name '{name}' speaks of '{reading.words}'"
        yield _Witness(category, reading.words, believed * share * reading.strength, clue)
