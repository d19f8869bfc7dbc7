"""Findings on a description that do not stop its reading: doubtful masses, links without mass, unread elements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from geom.mass.inertia import is_physical
from schemas.diagnostics import Diagnostic, finding
from schemas.robot_description import DescribedLink, Inertial, UnreadElement


def inertial_notes(link: str, inertial: Inertial) -> Iterator[Diagnostic]:
    """Of a mass that is not positive, or a tensor that no body has."""
    where = inertial.source.location
    if inertial.mass_kg <= 0.0:
        headline = f"link '{link}' states a mass of {inertial.mass_kg:g} kg"
        yield finding("robot/invalid-mass", headline, where=where, value=inertial.mass_kg, bound=0.0, unit="kg")
    elif inertial.inertia_kgm2 is not None and not is_physical(inertial.inertia_kgm2):
        headline = f"link '{link}' states an inertia tensor that no body has"
        diagonal = " ".join(f"{v:g}" for v in inertial.inertia_kgm2.diagonal())
        yield finding("robot/invalid-inertia", headline, where=where, value=diagonal, unit="kg m2")


def link_notes(links: Sequence[DescribedLink]) -> Iterator[Diagnostic]:
    """One note for all links with shapes that have mass from nowhere, at the first of them."""
    bare = [link for link in links if link.inertia_source == "missing" and link.shapes]
    if bare:
        names = ", ".join(f"'{link.name}'" for link in bare[:5]) + (", ..." if len(bare) > 5 else "")
        headline = f"{len(bare)} link{'s' * (len(bare) > 1)} with shapes state no mass: {names}"
        yield finding("robot/missing-inertial", headline, where=bare[0].source.location, value=len(bare))


def unread_notes(unread: Sequence[UnreadElement]) -> Iterator[Diagnostic]:
    """One note for each kind of element, at the first of its kind, with their number."""
    by_tag: dict[str, list[UnreadElement]] = {}
    for element in unread:
        by_tag.setdefault(element.tag, []).append(element)
    for tag, elements in by_tag.items():
        count = f"{len(elements)} times, first " if len(elements) > 1 else ""
        headline = f"<{tag}> is not understood and kept as text ({count}in '{elements[0].inside}')"
        yield finding("robot/unread-element", headline, where=elements[0].source.location, value=len(elements))
