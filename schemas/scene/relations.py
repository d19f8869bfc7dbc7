"""Relations of the scene language as data: the table of words with the keys that each takes, and `Relation` made of it.

The meaning of a word is in `scenec.relations`, the judge's predicate of it in `scene_check.relations`; both are held to
this table by a test.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, create_model

from schemas.scene.written import Distance, Length, Written


@dataclass(frozen=True)
class RelationWord:
    """A row of the table. `kind` names the file of its meaning and the relation that the compiler works with; several
    words may share one, `reverse` ones with their members in reverse. `members` are the least and the largest number
    of them (None: any). Of `needs` exactly one key must be written; a key of `only_with` counts only with another;
    `radians` are keys that hold angles and have a twin in degrees. With `parts` the first member may name a part of
    its asset (`mug.handle`)."""

    word: str
    kind: str
    members: tuple[int, int | None] = (2, 2)
    keys: frozenset[str] = frozenset()
    needs: tuple[str, ...] = ()
    only_with: tuple[tuple[str, str], ...] = ()
    radians: tuple[str, ...] = ()
    reverse: bool = False
    parts: bool = False


_DIRECTIONAL = frozenset({"gap", "frame", "viewpoint"})
RELATION_WORDS = (
    RelationWord("left_of", "before", keys=_DIRECTIONAL),
    RelationWord("right_of", "before", keys=_DIRECTIONAL, reverse=True),
    RelationWord("front_of", "before", keys=_DIRECTIONAL),
    RelationWord("behind", "before", keys=_DIRECTIONAL, reverse=True),
    RelationWord("near", "near", keys=frozenset({"distance"}), needs=("distance",)),
    RelationWord("far_from", "far_from", keys=frozenset({"distance"}), needs=("distance",)),
    RelationWord("aligned", "aligned", (2, None), frozenset({"axis", "tolerance", "frame"})),
    RelationWord(
        "facing", "facing", keys=frozenset({"tolerance", "tolerance_deg"}), radians=("tolerance",), parts=True
    ),
    RelationWord("between", "between", (3, 3), frozenset({"tolerance"})),
    RelationWord("above", "above", keys=frozenset({"gap", "overlap"})),
    RelationWord("below", "above", keys=frozenset({"gap", "overlap"}), reverse=True),
    RelationWord(
        "surrounding",
        "surrounding",
        (3, None),
        frozenset({"evenly", "tolerance", "tolerance_deg", "least_angle", "least_angle_deg", "distance"}),
        needs=("evenly", "least_angle", "least_angle_deg"),
        only_with=(("tolerance", "evenly"), ("tolerance_deg", "evenly")),
        radians=("tolerance", "least_angle"),
    ),
    RelationWord("in_line", "in_line", (2, None), frozenset({"axis", "spacing", "tolerance", "frame"})),
)
WORD = {row.word: row for row in RELATION_WORDS}
RELATION_KINDS = tuple(dict.fromkeys(row.kind for row in RELATION_WORDS))


def _known(kind: str) -> str:
    if kind not in RELATION_KINDS:
        raise ValueError(f"one of {', '.join(RELATION_KINDS)}")
    return kind


RelationKind = Annotated[str, AfterValidator(_known), Field(json_schema_extra={"enum": list(RELATION_KINDS)})]


def _members_field(row: RelationWord) -> tuple[Any, Any]:
    """Type and default of the field of a word, for pydantic."""
    least, most = row.members
    if most == least:
        return tuple[(str,) * least] | None, None
    return tuple[str, ...] | None, Field(default=None, min_length=least, max_length=most)


_fields: dict[str, Any] = {row.word: _members_field(row) for row in RELATION_WORDS}
_Words = create_model("_Words", __base__=Written, **_fields)


class Relation(_Words):
    """One relation between placed nodes; exactly one of the first keys is given.

    The default viewer is at -y of the support's frame and looks toward +y: `left_of: [a, b]` puts the whole
    footprint of a at smaller x than that of b, by `gap`; `behind` at larger y. `frame` names the anchor or object whose
    axes count, `viewpoint` turns the viewer. `near` and `far_from` bound the distance of footprints, `aligned` the
    offset of origins across `axis`, `facing` turns the front (+x) of a toward b, `between: [a, b, c]` puts a's origin
    between those of b and c. `above` compares heights, `surrounding` the angles of origins about that of the first,
    `in_line` puts origins on a line along `axis` in the order written.
    """

    gap: Distance = Field(default=0.0, description="metres between the two: at least")
    distance: Length | tuple[Length, Length] | None = Field(
        default=None, description="near, surrounding: at most; far_from: at least; two numbers: from one to the other"
    )
    axis: Literal["x", "y"] = Field(default="x", description="of the frame: the line on which the origins lie")
    tolerance: Distance | None = Field(
        default=None, description="aligned, between, in_line: metres; facing, surrounding: radians"
    )
    tolerance_deg: Distance | None = Field(default=None, description="facing, surrounding: degrees")
    frame: str | None = Field(default=None, description="anchor, node, object or `world` whose axes count")
    viewpoint: Literal["front", "back", "left", "right"] = Field(
        default="front", description="the side on which the viewer stands"
    )
    overlap: bool = Field(default=False, description="of above and below: the footprints overlap, too")
    evenly: bool = Field(default=False, description="of surrounding: equal angles between neighbours")
    least_angle: Length | None = Field(default=None, description="of surrounding: between neighbours, radians")
    least_angle_deg: Length | None = Field(default=None, description="the same in degrees")
    spacing: Length | None = Field(default=None, description="of in_line: from one origin to the next")

    @property
    def words(self) -> tuple[RelationWord, ...]:
        """The words that it uses; a valid relation uses one."""
        return tuple(row for row in RELATION_WORDS if getattr(self, row.word) is not None)

    def members(self, row: RelationWord) -> tuple[str, ...]:
        """The names written after a word that it uses."""
        return getattr(self, row.word)
