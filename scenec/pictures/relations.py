"""Relations as arrows: read as they were written, one arrow for all that is said of the same two things."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise

from matplotlib.axes import Axes

from scenec.ir.problem import FloatArray, RelationIR
from scenec.pictures.canvas import arrow


def draw_relations(
    axes: Axes,
    relations: Iterable[RelationIR],
    at: Mapping[str, FloatArray],
    colour_of: Callable[[RelationIR], str],
    *,
    order: float,
    numbered: bool = False,
) -> None:
    """An arrow from the subject of each relation to its object, where both have a point in `at`."""
    words: dict[tuple[str, str, str], list[str]] = {}
    for relation in relations:
        said = relation.word or relation.kind
        if numbered and relation.path:
            said += f" [{relation.path[-1]}]"
        for first, second in pairwise(relation.as_written):
            if first in at and second in at:
                words.setdefault((first, second, colour_of(relation)), []).append(said)
    for (first, second, colour), said in words.items():
        arrow(axes, at[first], at[second], ", ".join(dict.fromkeys(said)), order=order, color=colour, bend=0.16)
