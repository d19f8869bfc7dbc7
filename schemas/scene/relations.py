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
    of them (None: any). Of `needs` one key must be written; `radians` are keys that hold angles."""

    word: str
    kind: str
    members: tuple[int, int | None] = (2, 2)
    keys: frozenset[str] = frozenset()
    needs: tuple[str, ...] = ()
    radians: tuple[str, ...] = ()
    reverse: bool = False


_DIRECTIONAL = frozenset({"gap", "frame", "viewpoint"})
RELATION_WORDS = (
    RelationWord("left_of", "before", keys=_DIRECTIONAL),
    RelationWord("right_of", "before", keys=_DIRECTIONAL, reverse=True),
    RelationWord("front_of", "before", keys=_DIRECTIONAL),
    RelationWord("behind", "before", keys=_DIRECTIONAL, reverse=True),
    RelationWord("near", "near", keys=frozenset({"distance"}), needs=("distance",)),
    RelationWord("far_from", "far_from", keys=frozenset({"distance"}), needs=("distance",)),
    RelationWord("aligned", "aligned", (2, None), frozenset({"axis", "tolerance", "frame"})),
    RelationWord("facing", "facing", keys=frozenset({"tolerance", "tolerance_deg"}), radians=("tolerance",)),
    RelationWord("between", "between", (3, 3), frozenset({"tolerance"})),
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
    between those of b and c.
    """

    gap: Distance = 0.0
    distance: Length | None = Field(default=None, description="of near (at most) and far_from (at least)")
    axis: Literal["x", "y"] = "x"
    tolerance: Distance | None = Field(default=None, description="aligned, between: metres; facing: radians")
    tolerance_deg: Distance | None = None
    frame: str | None = None
    viewpoint: Literal["front", "back", "left", "right"] = "front"

    @property
    def words(self) -> tuple[RelationWord, ...]:
        """The words that it uses; a valid relation uses one."""
        return tuple(row for row in RELATION_WORDS if getattr(self, row.word) is not None)

    def members(self, row: RelationWord) -> tuple[str, ...]:
        """The names written after a word that it uses."""
        return getattr(self, row.word)
