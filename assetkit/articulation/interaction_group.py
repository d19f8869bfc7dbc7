"""The interaction group of a joint, from geometry, words and category, with confidence; `unknown` where they differ.

Independent clues for one group add up as a noisy or (Pearl 1988, section 4.3.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from assetkit.articulation.group_by_shape import ShapeReading
from assetkit.articulation.group_by_words import WordReading
from assetkit.taxonomy.tables import interaction_groups
from schemas.articulation import JointTask
from schemas.asset import Role
from schemas.evidence import Evidence, default, inferred
from schemas.mechanism import MechanismJointKind

UNKNOWN = "unknown"
# Of a word alone, where geometry fits no group; and of the usual group of the category, which only supports others.
WORD_ALONE, CATEGORY_SHARE = 0.6, 0.35
LEAD = 0.12  # the best group must lead by this much, and be this sure:
LEAST = 0.3
RIVAL_SHARE = 0.5  # of the second group's chance is taken from the first one's confidence

ROLE_OF_TASK: dict[JointTask, Role] = {"open": "openable", "turn": "turnable", "press": "pressable"}


@cache
def tasks() -> dict[str, JointTask]:
    """The task of each group, by the roles that the table gives to things of the group."""
    return {
        group.id: next(task for task, role in ROLE_OF_TASK.items() if role in group.roles)
        for group in interaction_groups().values()
    }


def decide_group(
    shape: ShapeReading, words: WordReading, category: Evidence[str] | None, kind: MechanismJointKind
) -> Evidence[str]:
    """The group with its evidence; `category` is the usual group of things of the object's category, if known.

    `unknown` with confidence 0: no group fits, no group leads, the names mean something else (a wheel), or
    names and geometry contradict each other and the category does not side with either.
    """
    if words.other:
        return default(UNKNOWN, f"named '{words.other}', which is in no group; {shape.reason}")
    usual = category.value if category is not None and kind in interaction_groups()[category.value].joints else ""
    support = CATEGORY_SHARE * category.confidence if category is not None and usual else 0.0
    contradict = bool(shape.chances) and bool(words.chances) and not set(shape.chances) & set(words.chances)
    if contradict and usual not in {*shape.chances, *words.chances}:
        named = ", ".join(words.chances)
        return default(UNKNOWN, f"contradicting: {shape.reason}, but named as {named}")
    chances = _combined(shape.chances, words.chances, usual, support)
    if not chances:
        return default(UNKNOWN, shape.reason)
    (best, chance), *others = sorted(chances.items(), key=lambda item: (-item[1], item[0]))
    rival = others[0][1] if others else 0.0
    confidence = round(chance * (1.0 - RIVAL_SHARE * rival), 3)
    if chance - rival < LEAD or confidence < LEAST:
        return default(UNKNOWN, f"undecided between {best} and {others[0][0]}" if others else shape.reason)
    clues = [f"geometry: {shape.reason}"] if best in shape.chances else []
    clues += [f"name: {clue}" for clue in words.clues] if best in words.chances else []
    clues += [f"category: usually {usual}"] if best == usual else []
    method = " and ".join(dict.fromkeys(clue.split(":")[0] for clue in clues))
    return inferred(best, method, confidence, inputs=tuple(clues))


def task_of(group: str, *, angular: bool) -> JointTask:
    """What is done with a joint of a group; of an unknown one, whether it turns or opens."""
    return tasks().get(group, "turn" if angular else "open")


def _combined(shape: Mapping[str, float], words: Mapping[str, float], usual: str, support: float) -> dict[str, float]:
    """Noisy or of the chances by group; a word for a group that geometry excludes counts less."""
    chances: dict[str, float] = {}
    for group in {**shape, **words}:
        by_word = words.get(group, 0.0) * (1.0 if group in shape else WORD_ALONE)
        miss = (1.0 - shape.get(group, 0.0)) * (1.0 - by_word)
        chances[group] = 1.0 - miss * (1.0 - (support if group == usual else 0.0))
    return chances
