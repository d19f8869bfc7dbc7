"""The terms of a licence from the text on record: its SPDX id where it is known, and what it forbids.

Sources: the SPDX License List for ids, the deeds of Creative Commons for their terms (`licences.csv`).
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from schemas.diagnostics import Diagnostic, Location, finding

NOT_RECORDED = frozenset({"", "unknown", "none", "noassertion", "n/a"})
# Phrases of terms under which nothing may be passed on. "All rights reserved" alone means that no right was granted.
_FORBIDS = re.compile(
    r"all rights reserved|(research|internal|personal|editorial|academic|educational|evaluation)[ -]+(use )?only"
    r"|(no|not( be)?|do not) redistribut|proprietary|confidential",
    re.IGNORECASE,
)
_CC_URL = re.compile(r"creativecommons\.org/(?:licenses/(by[a-z-]*)|publicdomain/(zero))/(\d\.\d)", re.IGNORECASE)
_CC_ADDRESS = re.compile(r"\S*creativecommons\.org\S*", re.IGNORECASE)
_CC_NAME = re.compile(r"cc-(by(?:-nc)?(?:-(?:sa|nd))?)-?v?(\d\.\d)(?:-(?:international|unported|generic|license))*")
_CC_WORDS = (
    (r"creative[ -]?commons", "cc"),
    (r"attribution", "by"),
    (r"non[ -]?commercial", "nc"),
    (r"share[ -]?alike", "sa"),
    (r"no[ -]?deriv(ative)?s?( works)?", "nd"),
)
_ALIASES = {
    "cc0": "CC0-1.0",
    "cc-0": "CC0-1.0",
    "cc0-1.0-universal": "CC0-1.0",
    "cc-zero": "CC0-1.0",
    "mit-license": "MIT",
    "expat": "MIT",
    "apache-license-2.0": "Apache-2.0",
    "apache-license-version-2.0": "Apache-2.0",
    "apache-2": "Apache-2.0",
    "bsd-3-clause-license": "BSD-3-Clause",
    "new-bsd": "BSD-3-Clause",
    "bsd-2-clause-license": "BSD-2-Clause",
    "zlib-license": "Zlib",
}
_JOINED = re.compile(r"\s+(AND|OR)\s+")  # of SPDX expressions; brackets are not read


@dataclass(frozen=True)
class LicenceTerms:
    """A licence with its conditions; `spdx` is its text on record where it is none of the known ones."""

    spdx: str
    name: str
    url: str = ""
    attribution: bool = True
    share_alike: bool = False
    non_commercial: bool = False
    no_derivatives: bool = False
    needs_text: bool = False

    @property
    def restrictions(self) -> tuple[str, ...]:
        """What has to be allowed by name: "nc", "nd"."""
        return ("nc",) * self.non_commercial + ("nd",) * self.no_derivatives


class LicenceVerdict(NamedTuple):
    """The licences that a release of an asset has to keep to, or the findings for which it is refused."""

    terms: tuple[LicenceTerms, ...]
    refused: tuple[Diagnostic, ...] = ()


@cache
def known_licences() -> dict[str, LicenceTerms]:
    """The rows of `licences.csv` by SPDX id."""
    with (files("assetkit.publishing") / "licences.csv").open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    return {
        row["spdx"]: LicenceTerms(
            row["spdx"],
            row["name"],
            row["url"],
            *(row[key] == "yes" for key in ("attribution", "share_alike", "non_commercial", "no_derivatives", "text")),
        )
        for row in rows
    }


def judge_licence(text: str, allowed: frozenset[str], where: Location) -> LicenceVerdict:
    """The terms of the licence `text` on record of an asset, or why it may not be released.

    `allowed` holds "nc" and "nd", and texts of licences that a person has read. In an SPDX expression all licences
    joined by AND count; of those joined by OR the first that may be released.
    """
    if text.strip().lower() in NOT_RECORDED:
        return LicenceVerdict((), (finding("asset/licence-missing", "no licence is on record", where=where),))
    if _FORBIDS.search(text):
        headline = f"the licence '{text}' forbids to pass the asset on"
        return LicenceVerdict((), (finding("asset/licence-forbids-release", headline, where=where, value=text),))
    if text in allowed:
        return LicenceVerdict((terms_of(text) or LicenceTerms(text, text),))
    pieces = _JOINED.split(text.strip())
    names, joints = pieces[::2], set(pieces[1::2])
    if len(joints) > 1 or any(mark in text for mark in (" WITH ",)):
        return LicenceVerdict((), (_unrecognised(text, where),))
    judged = [_judge_one(name, allowed, where) for name in names]
    if joints == {"OR"}:
        return next((each for each in judged if not each.refused), judged[0])
    refused = tuple(reason for each in judged for reason in each.refused)
    return LicenceVerdict(() if refused else tuple(terms for each in judged for terms in each.terms), refused)


def terms_of(text: str) -> LicenceTerms | None:
    """The known licence that `text` names: by SPDX id in any case, by name, by address; None for any other text, also
    for one with further words, which may be further conditions.
    """
    if address := _CC_URL.search(text):
        kind, zero, number = address.groups()
        terms = known_licences().get("CC0-1.0" if zero else f"CC-{kind.upper()}-{number}")
        beside = _CC_ADDRESS.sub("", text).strip(" ,;:()")
        return terms if not beside or terms_of(beside) == terms else None
    words = text.strip().lower()
    for pattern, short in _CC_WORDS:
        words = re.sub(pattern, short, words)
    words = re.sub(r"[\s_,]+", "-", words).removeprefix("the-")
    if cc := _CC_NAME.fullmatch(words):
        return known_licences().get(f"CC-{cc[1].upper()}-{cc[2]}")
    by_id = {spdx.lower(): terms for spdx, terms in known_licences().items()}
    return by_id.get(_ALIASES.get(words, words).lower())


def _judge_one(name: str, allowed: frozenset[str], where: Location) -> LicenceVerdict:
    terms = terms_of(name)
    if terms is None:
        return LicenceVerdict((), (_unrecognised(name, where),))
    lacking = [restriction for restriction in terms.restrictions if restriction not in allowed]
    if lacking:
        forbidden = {"nc": "commercial use", "nd": "changed versions"}
        headline = f"{terms.spdx} forbids {' and '.join(forbidden[each] for each in lacking)}"
        return LicenceVerdict(
            (), (finding("asset/licence-restricted", headline, where=where, value=", ".join(lacking)),)
        )
    return LicenceVerdict((terms,))


def _unrecognised(text: str, where: Location) -> Diagnostic:
    return finding("asset/licence-unrecognised", f"'{text}' is none of the known licences", where=where, value=text)
