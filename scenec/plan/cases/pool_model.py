"""Model of a pool: its things as tables of options, and layouts of them, in the owner's frame P. Metres, radians.

A thing's *options* are its orientations at the yaws of a fine grid, or its fixed poses. A *layout* has an option, an
origin and a rectangle around the footprint for each thing; many layouts are stored as arrays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, cos, inf, pi

import numpy as np
import shapely
from numpy.typing import NDArray

from scenec.ir.problem import Placement, Thing
from scenec.plan.cases.feasible import Feasible, feasible_on
from scenec.plan.cases.rectangles import AxisOrder
from scenec.relations.table import RELATIONS
from scenec.solve.model import Site, SolverModel
from scenec.solve.planar import SLACK_M, hull_of, polygon
from scenec.solve.search import fixed_pose_placements
from scenec.solve.shapes import Shape
from schemas.arrays import FloatArray, IntArray
from schemas.scene.geometry import SceneRelation

YAW_STEP = pi / 360.0
GRAIN_M, GRAIN_RAD = 1e-6, 1e-6  # cells are stored in whole micrometres and microradians (schemas.scene.runtime_plan)


@dataclass(frozen=True)
class YawExtents:
    """A stance turned: `edges` (k + 1,) yaws, `extent_m` (k + 1, 4) at these, `most_m` (k, 4) between two of them.

    The extent is that of the footprint from the asset origin towards -x, +x, -y, +y of P. `most_m` is an upper bound:
    a support function is the largest of sinusoids of amplitude `radius`, which rise little between close yaws.
    """

    edges: FloatArray
    extent_m: FloatArray
    most_m: FloatArray


def yaw_extents_of(shape: Shape, low: float, high: float) -> YawExtents:
    """The extents of a shape, with its load, over a range of yaws."""
    count = max(1, ceil((high - low) / YAW_STEP - 1e-9))
    edges = np.linspace(low, high, count + 1) if high > low else np.array([low, low])
    reach = extent_at(shape, edges)
    rise = shape.radius_m * (1.0 - cos((edges[1] - edges[0]) / 2.0))
    return YawExtents(edges, reach, np.maximum(reach[:-1], reach[1:]) + rise)


def extent_at(shape: Shape, yaw_rad: FloatArray) -> FloatArray:
    """Reach (k, 4), as in `YawExtents`, at yaws (k,)."""
    beyond = overhang_m(shape)
    x, y = (own_hull(shape) if beyond > 0.0 else shape.hull).T
    cosine, sine = np.cos(yaw_rad)[:, None], np.sin(yaw_rad)[:, None]
    px, py = cosine * x - sine * y, sine * x + cosine * y
    extent = np.stack([-px.min(axis=1), px.max(axis=1), -py.min(axis=1), py.max(axis=1)], axis=1)
    return extent + shape.radius_m * GRAIN_RAD + beyond  # a yaw may be rounded


def own_hull(shape: Shape) -> FloatArray:
    """Convex hull (n, 2) of the body alone, without its load."""
    return hull_of(np.concatenate([prism.outline_m for prism in shape.prisms[: shape.own]]))


def overhang_m(shape: Shape) -> float:
    """Largest overhang of the load of a body over its own footprint: 0 unless a place was drawn beyond it."""
    if shape.own == len(shape.prisms):
        return 0.0
    hull_polygon = polygon(own_hull(shape))
    out = float(shapely.distance(shapely.points(shape.hull), hull_polygon).max())
    return out if out > GRAIN_M else 0.0


@dataclass(frozen=True)
class Member:
    """One thing of a pool. Options (m,): `stance`, `yaw_rad`, `base_m`, `height_m`; `extent_m` (m, 4) as in
    `YawExtents`; `at_m` (m, 2) their origins in P, NaN where these are free. Only the first `grid` are drawn, the other
    is the pose that the solver found. `origin_m` (4,) bounds the origin in P; `overhang_m` by stance: see there."""

    thing: Thing
    shapes: tuple[Shape, ...]
    yaw_extents: Mapping[int, YawExtents]
    room: Mapping[int, Feasible]
    stance: IntArray
    yaw_rad: FloatArray
    base_m: FloatArray
    height_m: FloatArray
    extent_m: FloatArray
    at_m: FloatArray
    origin_m: FloatArray
    overhang_m: FloatArray
    grid: int
    pinned: bool

    @property
    def name(self) -> str:
        """The thing's name."""
        return self.thing.name

    @cached_property
    def footprint_m2(self) -> FloatArray:
        """Area (m,) of the rectangle around the footprint, by option."""
        return (self.extent_m[:, 0] + self.extent_m[:, 1]) * (self.extent_m[:, 2] + self.extent_m[:, 3])


@dataclass(frozen=True)
class PoolModel:
    """Members in the order of their names, the clearance between them, relations among them (frame P)."""

    members: tuple[Member, ...]
    clearance_m: float
    rules: tuple[SceneRelation, ...]
    model: SolverModel

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the members."""
        return tuple(member.name for member in self.members)

    @cached_property
    def index(self) -> dict[str, int]:
        """Number of a member by name."""
        return {name: k for k, name in enumerate(self.names)}

    @cached_property
    def least_gap_m(self) -> FloatArray:
        """(n, n) distance that two members must keep: the clearance, or more by a relation."""
        gap = np.full((len(self.members),) * 2, self.clearance_m)
        for rule in self.rules:
            if (least_m := RELATIONS[rule.kind].least_distance_m(rule)) is not None:
                a, b = (self.index[name] for name in rule.things)
                gap[a, b] = gap[b, a] = max(gap[a, b], least_m)
        return gap

    @cached_property
    def axis_orders(self) -> tuple[AxisOrder, ...]:
        """The orders of two members along x or y that relations demand, members by number."""
        orders = []
        for rule in self.rules:
            if (order := RELATIONS[rule.kind].axis_order(rule)) is not None:
                numbers = [self.index[name] for name in rule.things]
                orders.append(order._replace(first=numbers[order.first], second=numbers[order.second]))
        return tuple(orders)

    @cached_property
    def level(self) -> bool:
        """Whether any two members have a common height in every option."""
        bases = [(m.base_m + float(m.thing.place.origin_P_m[2])) for m in self.members]
        low = max(float(base.max()) for base in bases)
        high = min(float((base + m.height_m).min()) for base, m in zip(bases, self.members, strict=True))
        return high > low + 1e-9


@dataclass
class Layouts:
    """`option` (l, n), `origin_m` (l, n, 2) and `rect_m` (l, n, 4) of l layouts, by family."""

    option: IntArray
    origin_m: FloatArray
    rect_m: FloatArray
    family: list[str]

    def __len__(self) -> int:
        return len(self.option)

    def take(self, rows: NDArray[np.generic] | Sequence[int]) -> Layouts:
        """Some of the layouts."""
        picked = np.asarray(rows)
        picked = np.flatnonzero(picked) if picked.dtype == bool else picked.astype(np.int64)
        family = [self.family[k] for k in picked.tolist()]
        return Layouts(self.option[picked], self.origin_m[picked], self.rect_m[picked], family)


def joined(parts: Sequence[Layouts]) -> Layouts:
    """Several lots of layouts as one."""
    return Layouts(
        np.concatenate([p.option for p in parts]),
        np.concatenate([p.origin_m for p in parts]),
        np.concatenate([p.rect_m for p in parts]),
        [family for p in parts for family in p.family],
    )


def pool_model_of(
    model: SolverModel,
    names: Sequence[str],
    fixed: Mapping[str, Placement],
    solved: Mapping[str, Placement],
) -> PoolModel:
    """The model of some things of one owner; those in `fixed` have one pose only. The `solved` assignment adds an
    option to each of the others."""
    inside = set(names)
    rules = tuple(rule for rule in model.rules if inside.issuperset(rule.things) and model.in_one_frame(rule))
    members = tuple(_member(model, name, fixed.get(name), solved[name]) for name in sorted(names))
    return PoolModel(members, model.problem.clearance_m, rules, model)


def _member(model: SolverModel, name: str, fixed: Placement | None, solved: Placement) -> Member:
    thing, shapes = model.things[name], model.shapes[name]
    domain, site = thing.domain, model.site(thing)
    (xa, xb), (ya, yb) = domain.x_m, domain.y_m
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    origin = np.array([xa + ox, xb + ox, ya + oy, yb + oy])
    poses: list[Placement] = []
    if fixed is not None:
        poses = [fixed]
    elif domain.fixed_poses:
        poses = [pose for k in range(len(domain.fixed_poses)) for pose in fixed_pose_placements(model, thing, k)]
    overhang = np.array([overhang_m(shape) for shape in shapes])
    if poses:
        used = sorted({pose.stance for pose in poses})
        return Member(
            thing,
            shapes,
            {},
            {s: feasible_on(site, shapes[s].height_m) for s in used},
            *_options(poses, shapes),
            np.array([(p.x_m + ox, p.y_m + oy) for p in poses]),
            np.array([-inf, inf, -inf, inf]),
            overhang,
            len(poses),
            True,
        )
    orientations = [s for s in model.allowed_orientations(thing) if _stands(shapes[s], site) <= site.top_m + SLACK_M]
    low, high = domain.yaw_rad
    yaw_extents = {s: yaw_extents_of(shapes[s], low, high) for s in orientations}
    drop = 1 if high - low > 2 * pi - 1e-9 or high == low else 0  # the end of a full turn equals its begin
    grid = [
        Placement(0.0, 0.0, yaw, s)
        for s in orientations
        for yaw in yaw_extents[s].edges[: len(yaw_extents[s].edges) - drop].tolist()
    ]
    return Member(
        thing,
        shapes,
        yaw_extents,
        {s: feasible_on(site, shapes[s].height_m) for s in orientations},
        *_options([*grid, solved], shapes),
        np.full((len(grid) + 1, 2), np.nan),
        origin,
        overhang,
        len(grid),
        False,
    )


@dataclass(frozen=True)
class MemberBatch:
    """Members of a relation, `numbers` in it, in many layouts (...): options (...), rectangles (..., 4) and origins
    (..., 2) of each."""

    members: Sequence[Member]
    numbers: Sequence[int]
    options: Sequence[IntArray]
    rects_m: Sequence[FloatArray]
    origins_m: Sequence[FloatArray]

    @property
    def fronts_rad(self) -> list[FloatArray]:
        """Headings (...) of the fronts."""
        return [front_of(member, option) for member, option in zip(self.members, self.options, strict=True)]

    @property
    def heights_m(self) -> list[tuple[FloatArray, FloatArray]]:
        """Lowest and highest z (...) in P of each member, without what it carries."""
        return [own_heights(member, option) for member, option in zip(self.members, self.options, strict=True)]


def floor_of(member: Member, option: IntArray) -> FloatArray:
    """Height (...) in P of what a member rests on, by option."""
    return member.base_m[option] + float(member.thing.place.origin_P_m[2])


def own_heights(member: Member, option: IntArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest z (...) in P of a member, without what it carries, by option."""
    low, high = np.array([(shape.own_low_m, shape.own_high_m) for shape in member.shapes]).T
    floor, stance = floor_of(member, option), member.stance[option]
    return floor + low[stance], floor + high[stance]


def front_of(member: Member, option: IntArray) -> FloatArray:
    """Direction (rad) in P of the front (+x of the asset frame), by option."""
    fronts = np.array([shape.front_rad for shape in member.shapes])
    return member.yaw_rad[option] + fronts[member.stance[option]]


def _stands(shape: Shape, site: Site) -> float:
    # Height that must stay below the top of a place: the load of contents may rise over the rim of a receptacle.
    return shape.height_m if site.is_surface else max(prism.high_m for prism in shape.prisms[: shape.own])


def _options(
    poses: Sequence[Placement], shapes: Sequence[Shape]
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    # Stance, yaw, base, height (m,) and reach (m, 4) of poses.
    stance, yaw = np.array([p.stance for p in poses]), np.array([p.yaw_rad for p in poses])
    reach = np.zeros((len(poses), 4))
    for s in sorted(set(stance.tolist())):
        rows = stance == s
        reach[rows] = extent_at(shapes[s], yaw[rows])
    height = np.array([shapes[s].height_m for s in stance.tolist()])
    return stance, yaw, np.array([p.base_m for p in poses]), height, reach


def around(member: Member, option: IntArray, origin_m: FloatArray) -> FloatArray:
    """Rectangles (m, 4) around the footprint at options (m,) and origins (m, 2), on whole grains of A."""
    reach = member.extent_m[option]
    shift = np.asarray(member.thing.place.origin_P_m[:2], dtype=np.float64)
    x, y = (origin_m - shift).T
    low = np.floor(np.stack([x - reach[:, 0], y - reach[:, 2]], axis=1) / GRAIN_M + 1e-4) * GRAIN_M + shift
    high = np.ceil(np.stack([x + reach[:, 1], y + reach[:, 3]], axis=1) / GRAIN_M - 1e-4) * GRAIN_M + shift
    return np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=1)
