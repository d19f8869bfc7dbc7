"""Unknown keys: what was meant, in the words of the section in which the key is written."""

from __future__ import annotations

from scenec.source.language import keys_at, sections
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.scene.relations import WORD
from source.hint import did_you_mean
from source.tree import Path, Tree, written

MOST_KEYS = 8  # are listed where none is near the one written
STANDING = ("on", "in", "inside", "on_top_of", "in_front_of")  # words of other languages for what a placement says


def unknown_key(tree: Tree, path: Path, where: Location) -> Diagnostic:
    """The finding about the unknown key at the end of a path."""
    key, above = str(path[-1]), f"`{written(path[:-1])}`" if path[:-1] else "the program"
    known = keys_at(tree, path[:-1])
    bound = ", ".join(known) or None
    if path[:-1] == ("reach",) and key in ("robot", "inverse_kinematics"):
        headline = f"`{written(path)}`: reach by the inverse kinematics of a robot is not computed"
        return finding("scene/robot-reach", headline, where=where, value=key)
    hint = did_you_mean(key, known)
    if len(path) == 3 and path[0] == "relations" and not hint:
        placing = "; what a thing stands on or in is its `placement`" if key in STANDING else ""
        headline = f"`{key}` is not a word of relations{placing}; the words are {', '.join(WORD)}"
        return finding("scene/unknown-key", headline, where=where, bound=bound)
    if len(path) == 1 and not hint:
        hint = did_you_mean(key, inside := sections())
        near = hint.removeprefix("; did you mean `").removesuffix("`?")
        hint = f"; did you mean `{inside[near]}`?" if hint else ""
    takes = f"; it takes {', '.join(known)}" if 0 < len(known) <= MOST_KEYS else ""
    return finding("scene/unknown-key", f"`{key}` is not a key of {above}{hint or takes}", where=where, bound=bound)
