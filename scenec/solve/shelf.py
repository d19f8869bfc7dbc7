"""Shelf packing with swap search: rows of axis-aligned footprints, first fit by decreasing depth (Coffman et al. 1980).

Relations along x are satisfied by the order within rows (members that must be left are at the left end), relations
along y by the order of rows; violated ones are repaired by swaps. Polygons with holes, keep-outs and placed things only
shorten the rows. Lengths in metres in the frame P of the owner.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, pi

import networkx as nx
import numpy as np
import shapely
from numpy.random import Generator
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Placement, Thing
from scenec.relations.table import RELATIONS
from scenec.solve.model import Site, SolverModel, is_box, yaw_allowed
from scenec.solve.placed import Placed
from scenec.solve.planar import AXIS
from scenec.solve.streams import stream
from schemas.scene.geometry import SceneRelation

NOISES = (0.0, 0.05, 0.05, 0.1, 0.1, 0.15, 0.15, 0.2, 0.2, 0.25)  # of the depths that sort things into rows


@dataclass(frozen=True)
class PackedItem:
    """A thing at its packing pose: extents (x0, y0, x1, y1) about the asset origin and bounds of that origin in P."""

    name: str
    stance: int
    yaw_rad: float
    x0: float
    y0: float
    x1: float
    y1: float
    x_range: tuple[float, float]
    y_range: tuple[float, float]

    @property
    def width(self) -> float:
        """Extent along x."""
        return self.x1 - self.x0

    @property
    def depth(self) -> float:
        """Extent along y."""
        return self.y1 - self.y0


@dataclass
class Bin:
    """A free interval of a row, and the items in it."""

    x0: float
    x1: float
    y0: float
    depth: float
    row: int
    items: list[int] = field(default_factory=list)
    used: float = 0.0


@dataclass(frozen=True)
class SeparationConstraint:
    """Origins (p_b - p_a) . (dx, dy) >= min_separation_m, which includes extents and gap; -1: a fixed thing."""

    a: int
    b: int
    dx: float
    dy: float
    min_separation_m: float


def item_of(model: SolverModel, thing: Thing, flip: bool = False) -> PackedItem | None:
    """A thing at the allowed quarter turn of least depth along y, or (flip) of greatest."""
    best: PackedItem | None = None
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    for stance in model.allowed_orientations(thing)[:4]:
        for yaw in _packing_yaws(thing.domain.yaw_rad):
            x0, y0, x1, y1 = model.shapes[thing.name][stance].turned(yaw).bounds
            item = PackedItem(thing.name, stance, yaw, x0, y0, x1, y1, (xa + ox, xb + ox), (ya + oy, yb + oy))
            if best is None or (item.depth > best.depth + 1e-9 if flip else item.depth < best.depth - 1e-9):
                best = item
        if best is not None:
            return best
    return best


def _packing_yaws(span_rad: tuple[float, float]) -> list[float]:
    quarters = [yaw_allowed(k * pi / 2, span_rad) for k in (0, 1, 2, 3)]
    yaws = [yaw for yaw in quarters if yaw is not None][:2]
    return yaws or [min(span_rad, key=lambda yaw: abs(((yaw + pi / 4) % (pi / 2)) - pi / 4))]


def free_area(model: SolverModel, site: Site, standing: Sequence[Placed], height_m: float) -> BaseGeometry:
    """Free area for footprints up to a height: all layers, less obstacles above, keep-outs and placed things."""
    layers = [polygon for low, _, polygon in site.layers if low < height_m]
    area = layers[0] if len(layers) == 1 else shapely.intersection_all(layers)
    blocked = [polygon for polygon, _, _ in site.above] + [keep[0] for keep in site.keep_outs]
    clearance = model.problem.clearance_m
    for placed in standing:
        blocked += [piece.buffer(clearance, join_style="mitre") for piece in placed.footprint]
    return area.difference(shapely.union_all(blocked)) if blocked else area


def free_intervals(area: BaseGeometry, y0: float, y1: float) -> list[tuple[float, float]]:
    """Intervals (low, high) of x over which the whole band [y0, y1] is free."""
    x0, _, x1, _ = area.bounds
    inside = 1e-9  # avoids slivers along the border
    taken = shapely.difference(shapely.box(x0, y0 + inside, x1, y1 - inside), area)
    spans = sorted((part.bounds[0], part.bounds[2]) for part in shapely.get_parts(taken) if part.area > 0.0)
    free, at = [], x0
    for low, high in spans:
        if low > at:
            free.append((at, low))
        at = max(at, high)
    return [*free, (at, x1)] if at < x1 else free


class Packing:
    """Rows of items on a free area; `left_over` are items without room."""

    def __init__(
        self, items: Sequence[PackedItem], rules: Sequence[SeparationConstraint], area: BaseGeometry, clearance_m: float
    ):
        self.items, self.rules, self.area, self.clearance = items, rules, area, clearance_m
        self.x_rank = _ranks(items, rules, "x")
        self.y_preds: dict[int, list[int]] = {}
        for rule in rules:
            if rule.a >= 0 and rule.b >= 0 and abs(rule.dy) > AXIS:
                first, second = (rule.a, rule.b) if rule.dy > 0 else (rule.b, rule.a)
                self.y_preds.setdefault(second, []).append(first)
        self.y_rank = _ranks(items, rules, "y")
        self.is_box = isinstance(area, Polygon) and len(area.exterior.coords) == 5 and is_box(area)
        self.bins: list[Bin] = []
        self.bin_of: list[int] = []
        self.left_over: list[int] = []
        self.x: list[float] = []
        self.y: list[float] = []

    def fill(self, depths: Sequence[float]) -> None:
        """Opens rows from the front; each item goes to the first interval with room, in the order of `depths`, deepest
        first."""
        items, clearance = self.items, self.clearance
        _, area_y0, _, area_y1 = self.area.bounds
        order = sorted(range(len(items)), key=lambda i: (self.y_rank[i] if self.y_preds else 0.0, -depths[i]))
        self.bins, self.left_over = [], []
        self.bin_of, row, top = [-1] * len(items), -1, area_y0 - clearance
        for i in order:
            item = items[i]
            after = max(
                (self.bins[self.bin_of[p]].row for p in self.y_preds.get(i, ()) if self.bin_of[p] >= 0), default=-1
            )
            home = next((k for k, b in enumerate(self.bins) if b.row > after and self._takes(b, item)), None)
            if home is None:
                y0 = max(top + clearance, item.y_range[0] + item.y0)
                y1 = y0 + item.depth
                if y1 <= area_y1 + 1e-12 and y0 - item.y0 <= item.y_range[1]:
                    x0, _, x1, _ = self.area.bounds
                    row += 1
                    for low, high in [(x0, x1)] if self.is_box else free_intervals(self.area, y0, y1):
                        self.bins.append(Bin(low, high, y0, item.depth, row))
                        if home is None and self._takes(self.bins[-1], item):
                            home = len(self.bins) - 1
                    top = y1
            if home is None:
                self.left_over.append(i)
                continue
            chosen = self.bins[home]
            chosen.items.append(i)
            chosen.used += item.width + clearance
            self.bin_of[i] = home

    def _takes(self, b: Bin, item: PackedItem) -> bool:
        if item.depth > b.depth + 1e-12 or b.used + item.width > b.x1 - b.x0 + 1e-12:
            return False
        low, high = max(b.x0, item.x_range[0] + item.x0), min(b.x1, item.x_range[1] + item.x1)
        bottom = max(b.y0, item.y_range[0] + item.y0)
        return (
            high - low >= item.width - 1e-12
            and bottom <= min(b.y0 + b.depth, item.y_range[1] + item.y1) - item.depth + 1e-12
        )

    def spread_rows(self) -> None:
        """Spreads rows evenly over the unused depth (a plain rectangle only)."""
        if not self.is_box or not self.bins or any(i.y_range != (-inf, inf) for i in self.items):
            return
        slack = self.area.bounds[3] - max(b.y0 + b.depth for b in self.bins)
        gap = slack / (self.bins[-1].row + 2)
        for b in self.bins:
            b.y0 += gap * (b.row + 1)

    def settle(self, spread: bool) -> bool:
        """Computes positions of all items; False where a range is violated."""
        self.x, self.y = [0.0] * len(self.items), [0.0] * len(self.items)
        done = [self._settle(b, spread) for b in self.bins]
        return all(done)

    def _settle(self, b: Bin, spread: bool) -> bool:
        rank, items = self.x_rank, self.items
        b.items.sort(key=lambda i: (rank[i], max(items[i].x_range[0], b.x0)))
        slack = b.x1 - b.x0 - b.used + self.clearance
        gap, at, ok = slack / (len(b.items) + 1) if spread else 0.0, b.x0, True
        pushed = spread
        for i in b.items:
            item = items[i]
            if not pushed and rank[i] > 0.5:
                at, pushed = at + max(slack, 0.0), True  # members that must be right are at the right end
            at = max(at + gap, item.x_range[0] + item.x0)
            self.x[i] = at - item.x0
            self.y[i] = max(b.y0, item.y_range[0] + item.y0) - item.y0
            ok = ok and self.x[i] <= item.x_range[1] + 1e-12
            at += item.width + self.clearance
        return ok and at - self.clearance <= b.x1 + 1e-9

    def broken(self) -> list[tuple[float, SeparationConstraint]]:
        """Violated constraints, each with the amount (m)."""
        x, y, violated = self.x, self.y, []
        for rule in self.rules:
            over = rule.min_separation_m
            if rule.a >= 0:
                over += rule.dx * x[rule.a] + rule.dy * y[rule.a]
            if rule.b >= 0:
                over -= rule.dx * x[rule.b] + rule.dy * y[rule.b]
            if over > 1e-10:
                violated.append((over, rule))
        return violated

    def swap_until_right(self, rng: Generator, steps: int, spread: bool) -> int:
        """Swaps members of violated constraints while the total violation does not grow; returns the steps taken."""
        bad = self.broken()
        cost, taken = sum(over for over, _ in bad), 0
        movable = [i for i in range(len(self.items)) if self.bin_of[i] >= 0]
        picks = rng.random((steps, 3)) if bad else np.zeros((0, 3))
        for one, two, three in picks.tolist():
            if not bad:
                break
            taken += 1
            rule = bad[int(one * len(bad))][1]
            ends = [i for i in (rule.a, rule.b) if i >= 0 and self.bin_of[i] >= 0]
            if not ends:
                break
            i, j = ends[int(two * len(ends))], movable[int(three * len(movable))]
            p, q = self.bins[self.bin_of[i]], self.bins[self.bin_of[j]]
            if p is q or not self._may_swap(p, i, j) or not self._may_swap(q, j, i):
                continue
            self._exchange(i, j)
            if self._settle(p, spread) and self._settle(q, spread):
                now = self.broken()
                if (total := sum(over for over, _ in now)) <= cost:
                    bad, cost = now, total
                    continue
            self._exchange(j, i)
            self._settle(p, spread)
            self._settle(q, spread)
        return taken

    def _may_swap(self, b: Bin, out: int, into: int) -> bool:
        item = self.items[into]
        return (
            item.depth <= b.depth + 1e-12
            and b.used + item.width - self.items[out].width - self.clearance <= b.x1 - b.x0 + 1e-12
        )

    def _exchange(self, i: int, j: int) -> None:
        p, q = self.bins[self.bin_of[i]], self.bins[self.bin_of[j]]
        change = self.items[j].width - self.items[i].width
        p.items[p.items.index(i)], q.items[q.items.index(j)] = j, i
        p.used, q.used = p.used + change, q.used - change
        self.bin_of[i], self.bin_of[j] = self.bin_of[j], self.bin_of[i]


def _ranks(items: Sequence[PackedItem], rules: Sequence[SeparationConstraint], axis: str) -> list[float]:
    # Rank of each item in [0, 1], strictly growing along every constraint: 0 first, 1 last, 0.5 unconstrained.
    # Raises NetworkXUnfeasible where constraints form a cycle.
    graph: nx.DiGraph[int] = nx.DiGraph()
    for rule in rules:
        d = rule.dx if axis == "x" else rule.dy
        if rule.a >= 0 and rule.b >= 0 and abs(d) > AXIS:
            graph.add_edge(*((rule.a, rule.b) if d > 0 else (rule.b, rule.a)))
    ranks = [0.5] * len(items)
    if graph:
        order = list(nx.topological_sort(graph))
        before, after = dict.fromkeys(order, 0), dict.fromkeys(order, 0)
        for i in order:
            before[i] = max((before[p] + 1 for p in graph.predecessors(i)), default=0)
        for i in reversed(order):
            after[i] = max((after[s] + 1 for s in graph.successors(i)), default=0)
        for i in order:
            ranks[i] = before[i] / max(before[i] + after[i], 1)
    return ranks


def separation_constraints(
    model: SolverModel,
    site: Site,
    items: Sequence[PackedItem],
    standing: Mapping[str, Placed],
    rules: Sequence[SceneRelation],
) -> list[SeparationConstraint]:
    """Constraints of directional relations among items, or between an item and placed things on the same owner."""
    number = {item.name: i for i, item in enumerate(items)}
    constraints = []
    for rule in rules:
        if (
            not RELATIONS[rule.kind].separable
            or rule.frame != site.parent
            or not any(name in number for name in rule.things)
        ):
            continue
        dx, dy = rule.direction
        min_separation_m, ends = rule.gap_m, []
        for name, sign in zip(rule.things, (1, -1), strict=True):
            if name in number:
                item = items[number[name]]
                hull = model.shapes[name][item.stance].turned(item.yaw_rad).hull
                shift = 0.0
            elif name in standing and standing[name].parent == site.parent:
                hull = standing[name].turned.hull
                shift = standing[name].x_P_m * dx + standing[name].y_P_m * dy
            else:
                break
            min_separation_m += sign * (shift + float((sign * (hull @ (dx, dy))).max()) * sign)
            ends.append(number.get(name, -1))
        if len(ends) == 2:
            constraints.append(SeparationConstraint(ends[0], ends[1], dx, dy, min_separation_m))
    return constraints


def pack_shelves(
    model: SolverModel,
    names: Sequence[str],
    standing: Mapping[str, Placed],
    rules: Sequence[SceneRelation],
    seed: int,
    steps: int,
) -> tuple[dict[str, Placement], int]:
    """Placements (in A) for as many of `names`, all of one place, as can be packed, and the number of steps."""
    things = [model.things[name] for name in names]
    site = model.site(things[0])
    items = [item for thing in things if (item := item_of(model, thing)) is not None]
    mates = [placed for placed in standing.values() if placed.parent == site.parent]
    area = free_area(model, site, mates, max(model.shapes[i.name][i.stance].height_m for i in items) if items else 0.0)
    if not items or area.is_empty:
        return {}, 1
    try:
        packing = Packing(
            items, separation_constraints(model, site, items, standing, rules), area, model.problem.clearance_m
        )
    except nx.NetworkXUnfeasible:
        return {}, 1
    rng, taken = stream(seed, "shelf", *names), 0
    best: tuple[tuple[int, float], dict[str, Placement]] | None = None
    for noise in NOISES:
        factors = 1.0 - noise * rng.random(len(items))
        depths = [item.depth * factor for item, factor in zip(items, factors.tolist(), strict=True)]
        for spread in (True, False):
            packing.fill(depths)
            taken += 1
            if packing.left_over and best is not None and len(packing.left_over) >= best[0][0]:
                break
            if spread:
                packing.spread_rows()
            packing.settle(spread)
            if not packing.left_over:
                taken += packing.swap_until_right(rng, 40 if spread else min(steps, 2000), spread)
            score = (len(packing.left_over), sum(over for over, _ in packing.broken()))
            if best is None or score < best[0]:
                best = (score, _placements(packing, site))
            if score == (0, 0.0) or taken >= steps:
                return best[1], taken
    assert best is not None
    return best[1], taken


def _placements(packing: Packing, site: Site) -> dict[str, Placement]:
    ox, oy = (float(v) for v in site.origin_P_m[:2])
    return {
        item.name: Placement(packing.x[i] - ox, packing.y[i] - oy, item.yaw_rad, item.stance)
        for i, item in enumerate(packing.items)
        if packing.bin_of[i] >= 0
    }
