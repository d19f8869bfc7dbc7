"""Basic colour terms (the eleven of English) of linear sRGB colours and of colour words.

A colour gets the basic term of the nearest colour, in CIELAB, among the 949 that the XKCD survey names (222,500 people;
matplotlib brings the table) as far as their names end in a basic term: "dark red" and "brick red" are red.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.colors import CSS4_COLORS, XKCD_COLORS, to_rgb
from scipy.spatial.distance import cdist

from schemas.appearance.conversions import srgb_to_linear
from schemas.arrays import FloatArray

BASIC_TERMS = ("black", "white", "grey", "red", "orange", "yellow", "green", "blue", "purple", "pink", "brown")
_SPELLINGS = {"gray": "grey", "violet": "purple"}
_WHITE_D65 = np.array([0.95047, 1.0, 1.08883])
_XYZ_OF_RGB = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)


def basic_terms(linear_rgb: FloatArray) -> list[str]:
    """The basic term of each linear sRGB colour of (n, 3)."""
    terms, known = _survey()
    near = cdist(lab_of(linear_rgb), known).argmin(axis=1)
    return [terms[i] for i in near]


def colour_by_name(word: str) -> str | None:
    """The basic term of a word that names a colour ("teal", "crimson", "gray"), or None."""
    word = _SPELLINGS.get(word, word)
    if word in BASIC_TERMS:
        return word
    code = XKCD_COLORS.get(f"xkcd:{word}") or CSS4_COLORS.get(word)
    return None if code is None else basic_terms(srgb_to_linear(np.array([to_rgb(code)])))[0]


def lab_of(linear_rgb: FloatArray) -> FloatArray:
    """(n, 3) CIE 1976 L*a*b* under D65 of linear sRGB."""
    t = np.clip(linear_rgb, 0.0, 1.0) @ _XYZ_OF_RGB.T / _WHITE_D65
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


@cache
def _survey() -> tuple[tuple[str, ...], FloatArray]:
    """Basic terms and CIELAB values of the survey's colours whose names end in a basic term."""
    last = {name: name.removeprefix("xkcd:").split()[-1] for name in XKCD_COLORS}
    named = {name: _SPELLINGS.get(word, word) for name, word in last.items()}
    basic = [(term, XKCD_COLORS[name]) for name, term in named.items() if term in BASIC_TERMS]
    return tuple(term for term, _ in basic), lab_of(srgb_to_linear(np.array([to_rgb(code) for _, code in basic])))
