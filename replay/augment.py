"""From a recorded episode to variants with new static objects: the order of the steps, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from replay.candidates import Choices
from replay.envelope import Envelope, Settings, swept_envelope
from replay.episode import Episode
from replay.insert import Site, insert, sites
from replay.recorded import stop
from replay.room import Room, obstacles
from replay.supports import Support, supports, used_supports
from schemas.diagnostics import Diagnostic, finding
from schemas.replay import Variant

REFERENCE_TOP_M = 0.1  # height at which free area is reported


@dataclass(frozen=True)
class Prepared:
    """An episode with what is proven about it: computed once, used for every variant."""

    episode: Episode
    envelope: Envelope
    sites: tuple[Site, ...]


def prepare(episode: Episode, settings: Settings, wanted_supports: Sequence[str] = ()) -> Prepared:
    """Envelope and rooms. Supports are those named, else those on which recorded objects stood, else all of them.

    Raises InvalidInput (`replay/no-support`) where there is none, or none of a name.
    """
    envelope = swept_envelope(episode, settings)
    standing = obstacles(episode)
    rooms = [Room(support, envelope, standing) for support in chosen_supports(episode, wanted_supports)]
    return Prepared(episode, envelope, sites(rooms, episode.cameras))


def chosen_supports(episode: Episode, wanted: Sequence[str]) -> tuple[Support, ...]:
    """Raises InvalidInput (`replay/no-support`)."""
    known = supports(episode)
    names = ", ".join(support.name for support in known) or "none"
    unknown = [name for name in wanted if name not in {support.name for support in known}]
    if unknown:
        raise stop(
            "replay/no-support", f"the episode has no support '{unknown[0]}' (it has {names})", episode.source.name
        )
    if wanted:
        return tuple(support for support in known if support.name in wanted)
    if not known:
        raise stop("replay/no-support", "no fixture of the episode has a level top face", episode.source.name)
    return used_supports(episode, known) or known


def variants(
    prepared: Prepared, choices: Callable[[int, int], Choices], numbers: Iterable[int], wanted: int, seed: int
) -> Iterator[Variant]:
    """A variant for each number; `choices(seed, number)` says what is tried. Each depends on its number alone."""
    for number in numbers:
        chosen = choices(seed, number)
        rng = np.random.default_rng([seed, number, 1])
        put = insert(prepared.sites, chosen.candidates, wanted, rng)
        yield Variant(
            episode=prepared.episode.name,
            source=prepared.episode.source.name,
            seed=seed,
            number=number,
            clearance_m=prepared.envelope.clearance_m,
            objects_requested=wanted,
            inserted=tuple(one.stated for one in put),
            lights=chosen.lights,
            feasible_area_m2={site.room.support.name: site.room.free(REFERENCE_TOP_M).area for site in prepared.sites},
        )


def no_room(prepared: Prepared, variant: Variant) -> Diagnostic | None:
    """Why a variant has fewer objects than were asked for; None where it has them all."""
    if len(variant.inserted) == variant.objects_requested:
        return None
    site = max(prepared.sites, key=lambda one: one.room.support.area.area)
    room = site.room
    takers = [f"{name} {share:.0%}" for name, share in list(room.blocked_by(REFERENCE_TOP_M).items())[:3]]
    free = room.free(REFERENCE_TOP_M).area
    text = (
        f"variant {variant.number} has {len(variant.inserted)} of {variant.objects_requested} objects: "
        f"{free:.3f} of {room.support.area.area:.3f} m2 of '{room.support.name}' is free up to {REFERENCE_TOP_M} m"
    )
    if takers:
        text += f"; most is swept by {', '.join(takers)}"
    return finding("replay/no-room", text, value=len(variant.inserted), bound=variant.objects_requested)
