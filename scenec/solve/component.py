"""One component the ready way: the earlier assignment repaired, then what structured families propose."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from scenec.ir.problem import Placement
from scenec.solve.fixed_poses import match_spots
from scenec.solve.grid import spread_grid
from scenec.solve.model import Model
from scenec.solve.placed import Placed
from scenec.solve.repair import repaired
from scenec.solve.search import Effort, is_dense
from scenec.solve.shelf import pack_shelves
from scenec.solve.yaw_jitter import loosened

FAMILY_SHARE = 0.3  # of the steps; the rest is for exact search


def solve_readily(
    model: Model,
    names: Sequence[str],
    seed: int,
    effort: Effort,
    previous: Mapping[str, Placement],
    suspects: Iterable[str] | None = None,
) -> dict[str, Placed] | None:
    """Poses for all of `names` from `previous` or from families, repaired where they do not hold; or None.

    `previous` is kept as far as it holds; `suspects` are the things of it that may have changed (all, when None).
    """
    old = {name: previous[name] for name in names if name in previous}
    if old:
        found = repaired(model, names, old, seed, effort, suspects)
        if found is not None:
            return found
    proposal = propose(model, names, seed, effort)
    found = repaired(model, names, proposal, seed, effort) if proposal else None
    return found if found is None or is_dense(model, names) else loosened(model, found, seed)


def propose(model: Model, names: Sequence[str], seed: int, effort: Effort) -> dict[str, Placement]:
    """What structured families seat: things with spots by matching, several on one place evenly on a grid where
    nothing ties them and there is room, else by shelves; owners first."""
    proposal: dict[str, Placement] = {}
    placed: dict[str, Placed] = {}
    for members in _by_place(model, names):
        with_spots = [name for name in members if model.things[name].domain.spots]
        if with_spots:
            proposal |= match_spots(model, with_spots, placed)
        free = [name for name in members if not model.things[name].domain.spots]
        placed |= {name: model.put(name, proposal[name]) for name in with_spots if name in proposal}
        spread = spread_grid(model, free, placed, seed) if len(free) > 1 else None
        if spread is not None:
            effort.taken += 1
            proposal |= spread
            placed |= {name: model.put(name, placement) for name, placement in spread.items()}
        elif len(free) > 1:
            steps = int(FAMILY_SHARE * (effort.left - effort.taken))
            seated, taken = pack_shelves(model, free, placed, model.rules, seed, steps)
            effort.taken += taken
            proposal |= seated
            placed |= {name: model.put(name, placement) for name, placement in seated.items()}
    return proposal


def _by_place(model: Model, names: Sequence[str]) -> list[list[str]]:
    groups: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in sorted(names, key=lambda n: model.rank[n]):
        thing = model.things[name]
        groups[thing.parent, thing.place.name].append(name)
    return [sorted(members) for members in groups.values()]
