"""Augment one episode: from its envelope and free space to variants with new static objects (W, m), step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geom.pose import pose_from_quat
from replay.envelope.envelope import Envelope, Settings, swept_envelope
from replay.insertion.candidates import VariantChoices
from replay.insertion.free_space import FreeSpace, obstacles
from replay.insertion.insert import InsertionSite, PlacedCandidate, insert, sites
from replay.insertion.supports import Support, supports, used_supports
from replay.recording.episode import Episode
from replay.recording.recorded_numbers import invalid_recording
from replay.views.visibility import ConvexPolyhedron, convex_polyhedra, in_world, newly_hidden, task_pixels
from runtime_plan.bodies import physical_body
from schemas.diagnostics import Diagnostic, finding
from schemas.replay.documents import Variant
from schemas.scene.runtime_plan import PlanBody

VARIANT_DRAWS = 6  # draws of a variant that hides too much
REFERENCE_TOP_M = 0.1  # height at which free area is reported


@dataclass(frozen=True)
class PreparedEpisode:
    """An episode with its swept envelope and insertion sites: computed once, used for every variant."""

    episode: Episode
    envelope: Envelope
    sites: tuple[InsertionSite, ...]


def prepare(episode: Episode, settings: Settings, wanted_supports: Sequence[str] = ()) -> PreparedEpisode:
    """Compute envelope and sites. Supports are those named, else those on which recorded objects rested, else all.

    `A=B` names support B, and objects on the place A of a plan go there; equal names match by themselves.
    Raises InvalidInput (`replay/no-support`) where there is none, or none of a name.
    """
    envelope = swept_envelope(episode, settings)
    fixed_obstacles = obstacles(episode)
    pairs = [wanted.rpartition("=") for wanted in wanted_supports]
    free_spaces = [
        FreeSpace(one, envelope, fixed_obstacles) for one in chosen_supports(episode, [name for _, _, name in pairs])
    ]
    return PreparedEpisode(
        episode, envelope, sites(free_spaces, episode.cameras, {place: name for place, _, name in pairs if place})
    )


def chosen_supports(episode: Episode, chosen: Sequence[str]) -> tuple[Support, ...]:
    """The supports with these names, else the used ones. Raises InvalidInput (`replay/no-support`)."""
    known = supports(episode)
    names = ", ".join(support.name for support in known) or "none"
    unknown = [name for name in chosen if name not in {support.name for support in known}]
    if unknown:
        raise invalid_recording(
            "replay/no-support", f"the episode has no support '{unknown[0]}' (it has {names})", episode.source.name
        )
    if chosen:
        return tuple(support for support in known if support.name in chosen)
    if not known:
        raise invalid_recording(
            "replay/no-support", "no fixture of the episode has a level top face", episode.source.name
        )
    return used_supports(episode, known) or known


def variants(
    prepared: PreparedEpisode,
    choices: Callable[[int, int], VariantChoices],
    numbers: Iterable[int],
    objects_requested: int,
    seed: int,
    packages: Path | None = None,
    most_hidden: float = 1.0,
) -> Iterator[Variant]:
    """A variant for each number; `choices(seed, number)` gives its candidates. Each depends on its number alone.

    No variant hides more than the share `most_hidden` of the task objects' pixels from a camera: it is drawn again, up
    to `VARIANT_DRAWS` times, then loses the objects that hide most. `packages` holds the packages of the candidates.
    """
    pixels = task_pixels(prepared.episode)

    solids: dict[PlanBody, list[ConvexPolyhedron]] = {}

    def hides(placed: Sequence[PlacedCandidate]) -> dict[str, float]:
        """Share of the task objects' pixels that is newly hidden, by camera."""
        poses = [pose_from_quat(np.array(one.stated.quat_wxyz), one.stated.position_m) for one in placed]
        for one in placed:
            if one.body not in solids:
                solids[one.body] = convex_polyhedra(physical_body(one.body, packages).body.shapes)
        pairs = zip(placed, poses, strict=True)
        return newly_hidden(pixels, [in_world(convex, X_WA) for one, X_WA in pairs for convex in solids[one.body]])

    for number in numbers:
        chosen = choices(seed, number)
        attempts: list[tuple[dict[str, float], tuple[PlacedCandidate, ...]]] = []
        while len(attempts) < VARIANT_DRAWS and (not attempts or _largest_share(attempts[-1][0]) > most_hidden):
            rng = np.random.default_rng([seed, number, 1 + len(attempts)])
            placed = insert(prepared.sites, chosen.candidates, objects_requested, rng)
            attempts.append((hides(placed), placed))
        hidden, placed = min(attempts, key=lambda one: _largest_share(one[0]))
        placed_before = len(placed)
        while placed and _largest_share(hidden) > most_hidden:
            less = [placed[:k] + placed[k + 1 :] for k in range(len(placed))]
            hidden, placed = min(((hides(fewer), fewer) for fewer in less), key=lambda one: _largest_share(one[0]))
        inserted = tuple(one.stated for one in placed)
        material_names = sorted({one.material for one in inserted if one.material})
        yield Variant(
            episode=prepared.episode.name,
            source=prepared.episode.source.name,
            seed=seed,
            number=number,
            clearance_m=prepared.envelope.clearance_m,
            objects_requested=objects_requested,
            inserted=inserted,
            materials={name: chosen.materials[name] for name in material_names},
            lights=chosen.lights,
            feasible_area_m2={
                site.free_space.support.name: site.free_space.free(REFERENCE_TOP_M).area for site in prepared.sites
            },
            camera_hidden=hidden,
            taken_out=placed_before - len(placed),
        )


def _largest_share(hidden: dict[str, float]) -> float:
    return max(hidden.values(), default=0.0)


def insertion_shortfall(prepared: PreparedEpisode, variant: Variant) -> Diagnostic | None:
    """Why a variant has fewer objects than requested; None where it has them all."""
    if len(variant.inserted) == variant.objects_requested:
        return None
    site = max(prepared.sites, key=lambda one: one.free_space.support.area.area)
    free_space = site.free_space
    sweeping_bodies = [
        f"{name} {share:.0%}" for name, share in list(free_space.blocked_by(REFERENCE_TOP_M).items())[:3]
    ]
    free = free_space.free(REFERENCE_TOP_M).area
    text = (
        f"variant {variant.number} has {len(variant.inserted)} of {variant.objects_requested} objects: "
        f"before them {free:.3f} of {free_space.support.area.area:.3f} m2 of '{free_space.support.name}' was free "
        f"up to {REFERENCE_TOP_M} m"
    )
    if sweeping_bodies:
        text += f"; most is swept by {', '.join(sweeping_bodies)}"
    if variant.taken_out:
        text += f"; {variant.taken_out} had a place and were taken out, because they hid too much of the task"
    return finding("replay/no-room", text, value=len(variant.inserted), bound=variant.objects_requested)
