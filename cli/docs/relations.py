"""The page `docs/reference/relations.md` from the files of the relations and the table of their words."""

from __future__ import annotations

from scenec.relations.table import WRITTEN_RELATIONS
from schemas.scene.relations import RELATION_WORDS, Relation, RelationWord

_INTRODUCTION = """# Relations

{count} words of the [scene language](scene-language.md), one in each entry of `relations`. A group means all its
members, a node with copies all its copies. Lengths are metres, angles radians; a key that ends in `_deg` takes degrees.
Footprint and height are those of an object itself, without what it carries; the origin is that of its asset.

| relation | holds when | takes |
|---|---|---|
"""
_FRAMES = """
The viewer stands at -y of the support's frame and looks toward +y. `viewpoint: back`, `left` or `right` lets the viewer
stand on another side. Between objects on different supports, of which one may turn, `frame:` must name the frame whose
axes count: the name of an anchor, node or object, or `world`. A key that has no effect on its relation is an error.

## Keys

| key | value | where it is absent |
|---|---|---|
"""


def page() -> str:
    """The page as text."""
    texts = {word: (members, holds) for meaning in WRITTEN_RELATIONS.values() for word, members, holds in meaning.page}
    rows = "".join(_row(row, *texts[row.word]) for row in RELATION_WORDS)
    words = {row.word for row in RELATION_WORDS}
    keys = "".join(_key(name) for name in Relation.model_fields if name not in words)
    return _INTRODUCTION.format(count=len(RELATION_WORDS)) + rows + _FRAMES + keys


def _row(row: RelationWord, members: str, holds: str) -> str:
    keys = ", ".join(f"`{key}`" for key in sorted(row.keys, key=list(Relation.model_fields).index))
    needed = f"; needs {' or '.join(f'`{key}`' for key in row.needs)}" if row.needs else ""
    return f"| `{row.word}: {members}` | {holds} | {keys}{needed} |\n"


def _key(name: str) -> str:
    field = Relation.model_fields[name]
    return f"| `{name}` | {field.description} | {'' if field.default is None else field.default} |\n"
