"""Draws relations as arrows in authored order, one arrow for all relations of the same two things."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise

from matplotlib.axes import Axes

from scenec.pictures.canvas import arrow
from schemas.arrays import FloatArray
from schemas.scene.geometry import SceneRelation


def draw_relations(
    axes: Axes,
    relations: Iterable[SceneRelation],
    at: Mapping[str, FloatArray],
    colour_of: Callable[[SceneRelation], str],
    *,
    order: float,
    numbered: bool = False,
) -> None:
    """An arrow from the subject of each relation to its object, where both have a point in `at`."""
    labels: dict[tuple[str, str, str], list[str]] = {}
    for relation in relations:
        label = relation.word or relation.kind
        if numbered and relation.path:
            label += f" [{relation.path[-1]}]"
        for first, second in pairwise(relation.as_written):
            if first in at and second in at:
                labels.setdefault((first, second, colour_of(relation)), []).append(label)
    for (first, second, colour), label in labels.items():
        arrow(axes, at[first], at[second], ", ".join(dict.fromkeys(label)), order=order, color=colour, bend=0.16)
