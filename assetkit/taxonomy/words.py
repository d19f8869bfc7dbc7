"""Splits names into words: `025_mug`, `CoffeeMug_v2` and `coffee-mug` hold `mug`; `scan` holds no `can`."""

from __future__ import annotations

import re
import unicodedata

# Camel case, digits and punctuation end a word; "USBStick" is USB and Stick.
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_MAX_WORDS = 40  # Names are short; what is longer is no name.


def words_of(name: str) -> tuple[str, ...]:
    """The words of a name, lower case and without accents, in order; single letters and digits are left out."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return tuple(word.lower() for word in _WORD.findall(plain) if len(word) > 1)[:_MAX_WORDS]


def singulars(word: str) -> tuple[str, ...]:
    """Possible singular forms of a word, by English spelling; () when it cannot be a plural."""
    if len(word) < 4 or not word.endswith("s") or word.endswith("ss"):
        return ()
    forms = [word[:-1]]
    if word.endswith("ies"):
        forms.append(word[:-3] + "y")
    if word.endswith("ves"):
        forms += [word[:-3] + "f", word[:-3] + "fe"]
    if word.endswith("es"):
        forms.append(word[:-2])
    return tuple(forms)
