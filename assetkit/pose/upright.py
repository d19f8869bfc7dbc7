"""Probability of each candidate up direction of an object in its reference pose, by Bayes' rule.

The prior is the up axis of the source with its confidence. The likelihoods come from the features of
`geom.features.upright_directions` and the reference pose of the category. The weights are the log odds of one feature
alone, estimated by hand, not fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.taxonomy.tables import Category
from geom.features.upright_directions import UprightFeatures, same_profile
from schemas.asset import Vec3, vec3
from schemas.evidence import Evidence
from schemas.model import Axis

# Prior probability that the source's up is that of the reference pose, by the source of the up axis: declared (by user,
# file or format), stated in the texts, default of the format. A wrong default mostly means that y is up.
DECLARED, STATED_IN_TEXTS, DEFAULT_AXIS = 0.95, 0.9, 0.5
DEFAULT_AXIS_Y = 0.3
TURN_NAMED = 0.8  # From this probability on an object of a known category is turned upright ...
TURN_UNNAMED = 0.97  # ... and from this one on an object of unknown category.
ALONG_AXIS_COSINE = 0.999  # cosine from which a direction is that axis
CLEARLY = 3.0  # From this ratio of probabilities on, two directions that look the same are distinguished.
FIRM_RAD = np.radians(20.0)  # Tipping angle from which a stance counts as fully stable.

_NARROW_TOP = {"neck", "cap", "pump head", "spout", "knob", "head"}  # Parts at the top, narrower than what is below.
_LEGS = {"leg"}


@dataclass(frozen=True)
class UprightCandidate:
    """One candidate up direction, (3,) in the frame of the object, with its probability and its features in words.

    `alike` are other directions in which the object looks the same; `probability` is that of all of them together.
    """

    up: Vec3
    probability: float
    signs: tuple[str, ...]
    alike: tuple[Vec3, ...] = ()

    @property
    def keeps_z(self) -> bool:
        """Whether +z is this way up, or one that looks the same."""
        return any(up[2] > ALONG_AXIS_COSINE for up in (self.up, *self.alike))


def rank_upright(
    features: Sequence[UprightFeatures], category: Category | None, up_axis: Evidence[Axis] | None
) -> tuple[UprightCandidate, ...]:
    """All candidates of `features`, the most likely first; () when the category has no upright pose or there are none.

    `category` is None when unknown. `up_axis` is the evidence for the source's up, which is +z of the frame; None when
    it is unknown, which makes the prior uniform.
    """
    if not features or (category is not None and category.stands == "any"):
        return ()
    prior = _prior(np.array([f.up for f in features]), up_axis)
    signs = [_signs(f, category) for f in features]
    logs = np.log(prior) + np.array([sum(weight for weight, _ in weighted) for weighted in signs])
    posterior = np.exp(logs - logs.max())
    posterior /= posterior.sum()
    candidates: list[UprightCandidate] = []
    left = [int(i) for i in np.argsort(-np.round(posterior, 9), kind="stable")]
    while left:
        first = left[0]
        same = [
            i
            for i in left
            if i == first or _indistinguishable(features[first], features[i], posterior[first], posterior[i])
        ]
        probability = round(float(posterior[same].sum()), 4)
        others = tuple(vec3(features[i].up) for i in same[1:])
        texts = tuple(text for _, text in signs[first])
        candidates.append(UprightCandidate(vec3(features[first].up), probability, texts, others))
        left = [i for i in left if i not in same]
    return tuple(sorted(candidates, key=lambda c: -c.probability))


def least_probability(best: UprightCandidate, category: Category | None, up_axis: Evidence[Axis] | None) -> float:
    """Probability from which the object is turned to the most likely direction; it is lower for y where z is only the
    default of the format.
    """
    against_default = up_axis is not None and up_axis.source == "default" and best.up[1] > ALONG_AXIS_COSINE
    return TURN_UNNAMED if category is None and not against_default else TURN_NAMED


def _indistinguishable(
    best: UprightFeatures, other: UprightFeatures, best_probability: float, probability: float
) -> bool:
    """Whether the object looks the same in two directions and the features prefer neither clearly."""
    return probability * CLEARLY > best_probability and same_profile(best, other)


def _prior(ups: np.ndarray, up_axis: Evidence[Axis] | None) -> np.ndarray:
    """Prior probability (k,) of each direction; sums to 1."""
    if up_axis is None:
        return np.full(len(ups), 1.0 / len(ups))
    given = (DECLARED, 0.0) if up_axis.source == "declared" else (STATED_IN_TEXTS, 0.0)
    if up_axis.source == "default":
        given = (DEFAULT_AXIS, DEFAULT_AXIS_Y)
    prior = np.full(len(ups), (1.0 - sum(given)) / len(ups))
    prior[ups[:, 2] > ALONG_AXIS_COSINE] += given[0]
    prior[ups[:, 1] > ALONG_AXIS_COSINE] += given[1]
    return prior / prior.sum()


def _signs(features: UprightFeatures, category: Category | None) -> list[tuple[float, str]]:
    """Features for or against this direction: log odds of each, and a text for the record."""
    firm = float(np.clip(features.tip_rad / FIRM_RAD, -1.0, 1.0))
    signs = [(2.0 * firm, f"falls when it leans by {max(np.degrees(features.tip_rad), 0.0):.0f} degrees")]
    if category is None:
        return [
            *signs,
            (3.0 * features.water, f"holds water of {features.water:.0%} of its hull"),
            (1.5 * features.under, f"has {features.under:.0%} of its hull free below"),
            (1.5 * (features.bottom - features.top), "is wider below than above"),
        ]
    parts = set(category.parts)
    if category.stands == "opening":
        signs.append((16.0 * min(features.water, 0.5), f"holds water of {features.water:.0%} of its hull"))
    if category.stands == "flat":
        signs.append(
            (2.0 * float(np.clip(features.flat, -1.5, 1.5)), f"is {np.exp(features.flat):.2g} times as wide as high")
        )
        signs.append((12.0 * min(features.water, 0.35), f"holds water of {features.water:.0%} of its hull"))
    if category.stands == "base" and category.opening == "maybe":  # A bottle that is a shell may be open below.
        signs.append((4.0 * min(features.water, 0.5), f"holds water of {features.water:.0%} of its hull"))
    if parts & _LEGS:
        signs.append((8.0 * min(features.under, 0.5), f"has {features.under:.0%} of its hull free below"))
    elif category.stands == "base" and parts & _NARROW_TOP:
        signs.append((3.0 * (features.bottom - features.top), "is narrower above than below"))
    if category.symmetry == "axial" and category.stands != "flat":
        signs.append((12.0 * min(features.round - 0.9, 0.06), f"is round from above to {features.round:.2f}"))
    if category.stands == "base" and category.symmetry == "axial":
        signs.append(
            (-1.5 * float(np.clip(features.flat, -1.0, 1.0)), f"is {np.exp(-features.flat):.2g} times as high as wide")
        )
    return signs
