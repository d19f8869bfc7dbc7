"""Which way up a thing stands in its reference pose: Bayes over the directions that may be up.

The source's own up is the prior, as sure as its evidence. What the category says of its reference pose turns the signs
of `geom.features.upright_directions` into likelihoods. The weights are logarithms of odds that a person would give
for one sign alone; they
are chosen, not fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.taxonomy.tables import Category
from geom.features.upright_directions import Stand, alike
from schemas.asset import Vec3, vec3
from schemas.evidence import Evidence
from schemas.model import Axis

# The chance that the source's up is that of the reference pose: said by the user, declared by the file or its format,
# told by its texts, only the format's habit. A habit is mostly wrong in one way: y is up in many files.
DECLARED, TOLD, HABIT = 0.95, 0.9, 0.5
HABIT_Y = 0.3
TURN = 0.8  # From this chance on an object is turned ...
TURN_UNNAMED = 0.97  # ... and from this one on when nobody knows what it is and something tells that it stands.
NEAR = 0.999  # cosine from which a direction is that axis
CLEARLY = 3.0  # times as likely: a sign tells two ways up apart
FIRM_RAD = np.radians(20.0)  # What must lean so far to fall stands firmly.

_NARROW_TOP = {"neck", "cap", "pump head", "spout", "knob", "head"}  # Parts at the top, narrower than what is below.
_LEGS = {"leg"}


@dataclass(frozen=True)
class Upright:
    """One direction that may be up, (3,) in the frame of the object, with its chance and the signs in words.

    `alike` are other directions in which the object looks the same; `chance` is that of all of them together.
    """

    up: Vec3
    chance: float
    signs: tuple[str, ...]
    alike: tuple[Vec3, ...] = ()

    @property
    def keeps_z(self) -> bool:
        """Whether +z is this way up, or one that looks the same."""
        return any(up[2] > NEAR for up in (self.up, *self.alike))


def uprights(stands: Sequence[Stand], category: Category | None, up_axis: Evidence[Axis] | None) -> tuple[Upright, ...]:
    """All candidates of `stands`, the most likely first; () when no way up is meant or the object spans no volume.

    `category` is None when unknown. `up_axis` is the evidence for the source's up, which is +z of the frame; None when
    nothing is known of it, so that every direction is as likely before the form is looked at.
    """
    if not stands or (category is not None and category.stands == "any"):
        return ()
    prior = _prior(np.array([s.up for s in stands]), up_axis)
    signs = [_signs(s, category) for s in stands]
    logs = np.log(prior) + np.array([sum(weight for weight, _ in told) for told in signs])
    chances = np.exp(logs - logs.max())
    chances /= chances.sum()
    found: list[Upright] = []
    left = [int(i) for i in np.argsort(-np.round(chances, 9), kind="stable")]
    while left:
        first = left[0]
        same = [i for i in left if i == first or _confused(stands[first], stands[i], chances[first], chances[i])]
        chance = round(float(chances[same].sum()), 4)
        others = tuple(vec3(stands[i].up) for i in same[1:])
        found.append(Upright(vec3(stands[first].up), chance, tuple(text for _, text in signs[first]), others))
        left = [i for i in left if i not in same]
    return tuple(sorted(found, key=lambda u: -u.chance))


def least_chance(best: Upright, category: Category | None, up_axis: Evidence[Axis] | None) -> float:
    """How likely the likeliest way up must be to turn the object; less is needed to say that y is up where only the
    habit of the format speaks for z.
    """
    against_habit = up_axis is not None and up_axis.source == "default" and best.up[1] > NEAR
    return TURN_UNNAMED if category is None and not against_habit else TURN


def _confused(best: Stand, other: Stand, best_chance: float, chance: float) -> bool:
    """Whether nothing tells two ways up apart: the same look, and no sign that prefers one clearly."""
    return chance * CLEARLY > best_chance and alike(best, other)


def _prior(ups: np.ndarray, up_axis: Evidence[Axis] | None) -> np.ndarray:
    """Chance (k,) of each direction before the form is looked at; sums to 1."""
    if up_axis is None:
        return np.full(len(ups), 1.0 / len(ups))
    given = (DECLARED, 0.0) if up_axis.source == "declared" else (TOLD, 0.0)
    if up_axis.source == "default":
        given = (HABIT, HABIT_Y)
    prior = np.full(len(ups), (1.0 - sum(given)) / len(ups))
    prior[ups[:, 2] > NEAR] += given[0]
    prior[ups[:, 1] > NEAR] += given[1]
    return prior / prior.sum()


def _signs(stand: Stand, category: Category | None) -> list[tuple[float, str]]:
    """Each sign for or against this way up: the logarithm of its odds, and what it is in words."""
    firm = float(np.clip(stand.tip_rad / FIRM_RAD, -1.0, 1.0))
    signs = [(2.0 * firm, f"falls when it leans by {max(np.degrees(stand.tip_rad), 0.0):.0f} degrees")]
    if category is None:
        return [
            *signs,
            (3.0 * stand.water, f"holds water of {stand.water:.0%} of its hull"),
            (1.5 * stand.under, f"has {stand.under:.0%} of its hull free below"),
            (1.5 * (stand.bottom - stand.top), "is wider below than above"),
        ]
    parts = set(category.parts)
    if category.stands == "opening":
        signs.append((16.0 * min(stand.water, 0.5), f"holds water of {stand.water:.0%} of its hull"))
    if category.stands == "flat":
        signs.append(
            (2.0 * float(np.clip(stand.flat, -1.5, 1.5)), f"is {np.exp(stand.flat):.2g} times as wide as high")
        )
        signs.append((12.0 * min(stand.water, 0.35), f"holds water of {stand.water:.0%} of its hull"))
    if category.stands == "base" and category.opening == "maybe":  # A bottle that is a shell may be open below.
        signs.append((4.0 * min(stand.water, 0.5), f"holds water of {stand.water:.0%} of its hull"))
    if parts & _LEGS:
        signs.append((8.0 * min(stand.under, 0.5), f"has {stand.under:.0%} of its hull free below"))
    elif category.stands == "base" and parts & _NARROW_TOP:
        signs.append((3.0 * (stand.bottom - stand.top), "is narrower above than below"))
    if category.symmetry == "axial" and category.stands != "flat":
        signs.append((12.0 * min(stand.round - 0.9, 0.06), f"is round from above to {stand.round:.2f}"))
    if category.stands == "base" and category.symmetry == "axial":
        signs.append(
            (-1.5 * float(np.clip(stand.flat, -1.0, 1.0)), f"is {np.exp(-stand.flat):.2g} times as high as wide")
        )
    return signs
