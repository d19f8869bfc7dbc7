"""From a recorded episode to variants with new static objects: the order of the steps, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geom.pose import pose_from_quat
from replay.envelope.envelope import Envelope, Settings, swept_envelope
from replay.insertion.candidates import Choices
from replay.insertion.free_space import Room, obstacles
from replay.insertion.insert import Put, Site, insert, sites
from replay.insertion.supports import Support, supports, used_supports
from replay.recording.episode import Episode
from replay.recording.recorded_numbers import stop
from replay.views.visibility import Convex, convexes, newly_hidden, placed, task_pixels
from runtime_plan.bodies import physical_body
from schemas.diagnostics import Diagnostic, finding
from schemas.replay import Variant
from schemas.scene.runtime_plan import PlanBody

TRIES = 6  # draws of a variant that hides too much
REFERENCE_TOP_M = 0.1  # height at which free area is reported


@dataclass(frozen=True)
class Prepared:
    """An episode with what is proven about it: computed once, used for every variant."""

    episode: Episode
    envelope: Envelope
    sites: tuple[Site, ...]


def prepare(episode: Episode, settings: Settings, wanted_supports: Sequence[str] = ()) -> Prepared:
    """Envelope and rooms. Supports are those named, else those on which recorded objects stood, else all of them.

    `A=B` names support B, and what stands on the place A of a plan goes there; equal names do so by themselves.
    Raises InvalidInput (`replay/no-support`) where there is none, or none of a name.
    """
    envelope = swept_envelope(episode, settings)
    standing = obstacles(episode)
    pairs = [wanted.rpartition("=") for wanted in wanted_supports]
    rooms = [Room(one, envelope, standing) for one in chosen_supports(episode, [name for _, _, name in pairs])]
    return Prepared(
        episode, envelope, sites(rooms, episode.cameras, {place: name for place, _, name in pairs if place})
    )


def chosen_supports(episode: Episode, chosen: Sequence[str]) -> tuple[Support, ...]:
    """Raises InvalidInput (`replay/no-support`)."""
    known = supports(episode)
    names = ", ".join(support.name for support in known) or "none"
    unknown = [name for name in chosen if name not in {support.name for support in known}]
    if unknown:
        raise stop(
            "replay/no-support", f"the episode has no support '{unknown[0]}' (it has {names})", episode.source.name
        )
    if chosen:
        return tuple(support for support in known if support.name in chosen)
    if not known:
        raise stop("replay/no-support", "no fixture of the episode has a level top face", episode.source.name)
    return used_supports(episode, known) or known


def variants(
    prepared: Prepared,
    choices: Callable[[int, int], Choices],
    numbers: Iterable[int],
    objects_requested: int,
    seed: int,
    packages: Path | None = None,
    most_hidden: float = 1.0,
) -> Iterator[Variant]:
    """A variant for each number; `choices(seed, number)` says what is tried. Each depends on its number alone.

    None hides more than the share `most_hidden` of the task objects' pixels from a camera: it is drawn again, up to
    `TRIES` times, and then goes without what hides most. `packages` holds the packages that candidates name.
    """
    seen = task_pixels(prepared.episode)

    solids: dict[PlanBody, list[Convex]] = {}

    def hides(put: Sequence[Put]) -> dict[str, float]:
        """Share of the task objects' pixels that is newly hidden, by camera."""
        poses = [pose_from_quat(np.array(one.stated.quat_wxyz), one.stated.position_m) for one in put]
        for one in put:
            if one.body not in solids:
                solids[one.body] = convexes(physical_body(one.body, packages).body.shapes)
        pairs = zip(put, poses, strict=True)
        return newly_hidden(seen, [placed(convex, X_WA) for one, X_WA in pairs for convex in solids[one.body]])

    for number in numbers:
        chosen = choices(seed, number)
        tries: list[tuple[dict[str, float], tuple[Put, ...]]] = []
        while len(tries) < TRIES and (not tries or _most(tries[-1][0]) > most_hidden):
            rng = np.random.default_rng([seed, number, 1 + len(tries)])
            put = insert(prepared.sites, chosen.candidates, objects_requested, rng)
            tries.append((hides(put), put))
        hidden, put = min(tries, key=lambda one: _most(one[0]))
        placed_before = len(put)
        while put and _most(hidden) > most_hidden:
            less = [put[:k] + put[k + 1 :] for k in range(len(put))]
            hidden, put = min(((hides(some), some) for some in less), key=lambda one: _most(one[0]))
        inserted = tuple(one.stated for one in put)
        worn = sorted({one.material for one in inserted if one.material})
        yield Variant(
            episode=prepared.episode.name,
            source=prepared.episode.source.name,
            seed=seed,
            number=number,
            clearance_m=prepared.envelope.clearance_m,
            objects_requested=objects_requested,
            inserted=inserted,
            materials={name: chosen.materials[name] for name in worn},
            lights=chosen.lights,
            feasible_area_m2={site.room.support.name: site.room.free(REFERENCE_TOP_M).area for site in prepared.sites},
            camera_hidden=hidden,
            taken_out=placed_before - len(put),
        )


def _most(hidden: dict[str, float]) -> float:
    return max(hidden.values(), default=0.0)


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
        f"before them {free:.3f} of {room.support.area.area:.3f} m2 of '{room.support.name}' was free "
        f"up to {REFERENCE_TOP_M} m"
    )
    if takers:
        text += f"; most is swept by {', '.join(takers)}"
    if variant.taken_out:
        text += f"; {variant.taken_out} had a place and were taken out, because they hid too much of the task"
    return finding("replay/no-room", text, value=len(variant.inserted), bound=variant.objects_requested)
