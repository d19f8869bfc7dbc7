"""Whether a small problem has a scene, by trying all poses of a grid; shares nothing with the compiler's arguments.

Boxes on one rectangular table; pairs by distance tables. Three answers. `yes`: some grid poses satisfy everything.
`no`: no grid poses satisfy even the rules relaxed by how far a grid pose may be from a real one, so nothing does.
`unclear`: in between, or too many poses.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import shapely
from shapely import Polygon

from scenec.ir.problem import Problem, Thing
from schemas.scene.geometry import SceneRelation

Truth = Literal["yes", "no", "unclear"]
MOST_POSES = 6000
YAW_STEP = np.radians(7.5)
NOISE = 1e-7
JOINT = {"between", "surrounding", "in_line"}  # relations of the origins of any number of things


class Grid:
    """Poses (x, y, yaw) of one thing: `poses` (n, 3), and how far a real pose may be from the nearest."""

    def __init__(self, thing: Thing, step_m: float) -> None:
        assert not thing.place.is_volume
        self.thing, self.outline = thing, thing.body.resting_orientations[0].prisms[0].outline_m
        low, high = thing.domain.yaw_rad
        square = np.allclose(np.ptp(self.outline, axis=0)[0], np.ptp(self.outline, axis=0)[1])
        high = min(high, low + (np.pi / 2 if square else np.pi))
        self.yaws = np.linspace(low, high, 1 + int(np.ceil((high - low) / YAW_STEP - 1e-9)))
        self.yaw_off = 0.5 * (self.yaws[1] - self.yaws[0]) if len(self.yaws) > 1 else 0.0
        west, south, east, north = thing.place.polygon.bounds
        (x0, x1), (y0, y1) = thing.domain.x_m, thing.domain.y_m
        self.x, self.x_off = _ticks(max(west, x0), min(east, x1), step_m)
        self.y, self.y_off = _ticks(max(south, y0), min(north, y1), step_m)
        self.radius = float(np.hypot(*self.outline.T).max())
        self.off = float(np.hypot(self.x_off, self.y_off)) + self.radius * self.yaw_off
        self.poses = np.array([(x, y, a) for a in self.yaws for x in self.x for y in self.y]).reshape(-1, 3)

    @property
    def heights_m(self) -> tuple[float, float]:
        """Lowest and highest z of the thing, wherever it lies on its place."""
        floor = float(self.thing.place.origin_P_m[2])
        return floor, floor + self.thing.body.resting_orientations[0].height_m

    def ring(self, yaw: float) -> np.ndarray:
        cos, sin = np.cos(yaw), np.sin(yaw)
        return self.outline @ np.array([[cos, sin], [-sin, cos]])


def _ticks(low: float, high: float, step_m: float) -> tuple[np.ndarray, float]:
    if low > high:
        return np.zeros(0), 0.0
    ticks = np.linspace(low, high, 1 + int(np.ceil((high - low) / step_m - 1e-9)))
    return ticks, 0.5 * (ticks[1] - ticks[0]) if len(ticks) > 1 else 0.0


def truth(problem: Problem, steps_m: tuple[float, ...] = (0.01, 0.005, 0.0025)) -> Truth:
    """The answer from all poses of a grid, refined until it is clear."""
    for step_m in steps_m:
        if (answer := _truth_on_grid(problem, step_m)) != "unclear":
            return answer
    return "unclear"


def _truth_on_grid(problem: Problem, step_m: float) -> Truth:
    grids = [Grid(thing, step_m) for thing in problem.things]
    strict, loose = (_poses_kept(problem, grids, relaxed) for relaxed in (False, True))
    if any(not mask.any() for mask in loose):
        return "no"
    if any(mask.sum() > MOST_POSES for mask in loose):
        return "unclear"
    if _some(problem, grids, strict, relaxed=False):
        return "yes"
    return "unclear" if _some(problem, grids, loose, relaxed=True) else "no"


def _poses_kept(problem: Problem, grids: list[Grid], relaxed: bool) -> list[np.ndarray]:
    """For each thing, which poses keep the rules that concern it alone."""
    masks = []
    for grid in grids:
        off = grid.off if relaxed else 0.0
        west, south, east, north = grid.thing.place.polygon.bounds
        mask = np.ones(len(grid.poses), bool)
        for k, yaw in enumerate(grid.yaws):
            ring, many = grid.ring(yaw), len(grid.poses) // len(grid.yaws)
            part = slice(k * many, (k + 1) * many)
            x, y = grid.poses[part, 0], grid.poses[part, 1]
            swing = grid.radius * grid.yaw_off if relaxed else 0.0
            x_off, y_off = (grid.x_off + swing, grid.y_off + swing) if relaxed else (0.0, 0.0)
            inside = (x + ring[:, 0].min() >= west - x_off - NOISE) & (x + ring[:, 0].max() <= east + x_off + NOISE)
            inside &= (y + ring[:, 1].min() >= south - y_off - NOISE) & (y + ring[:, 1].max() <= north + y_off + NOISE)
            for rule in problem.keep_outs:
                entered = _difference(np.asarray(rule.polygon.exterior.coords)[:-1], ring)
                inside &= _signed(np.stack([x, y], axis=1), entered) >= -off - NOISE
            if problem.reach is not None and grid.thing.name in problem.reach.members:
                distance = np.hypot(x - problem.reach.base_m[0], y - problem.reach.base_m[1])
                near = np.hypot(grid.x_off, grid.y_off) if relaxed else 0.0
                inside &= (distance <= problem.reach.most_m + near + NOISE) & (
                    distance >= problem.reach.least_m - near - NOISE
                )
            mask[part] = inside
        masks.append(mask)
    return masks


def _difference(one: np.ndarray, two: np.ndarray) -> Polygon:
    """All p for which `two` moved by p meets `one`."""
    hull = shapely.MultiPoint((one[:, None] - two[None]).reshape(-1, 2)).convex_hull
    assert isinstance(hull, Polygon)
    return hull


def _signed(points: np.ndarray, region: Polygon) -> np.ndarray:
    """Distance of points (n, 2) from a region, negative inside."""
    where = shapely.points(points)
    shapely.prepare(region)
    inside = shapely.contains(region, where)
    return np.where(inside, -shapely.distance(where, region.exterior), shapely.distance(where, region))


def _some(problem: Problem, grids: list[Grid], kept: list[np.ndarray], relaxed: bool) -> bool:
    """Whether some poses, one a thing, keep all rules of two and three things."""
    index = {grid.thing.name: k for k, grid in enumerate(grids)}
    poses = [grid.poses[mask] for grid, mask in zip(grids, kept, strict=True)]
    allowed = {}
    for a in range(len(grids)):
        for b in range(a + 1, len(grids)):
            allowed[a, b] = _pair(problem, grids[a], grids[b], poses[a], poses[b], index, relaxed)
    masks = [np.ones(len(p), bool) for p in poses]
    joint = [r for r in problem.relations if r.kind in JOINT]
    return _search(masks, allowed, [], poses, grids, joint, index, relaxed)


def _pair(problem, one: Grid, two: Grid, p: np.ndarray, q: np.ndarray, index, relaxed: bool) -> np.ndarray:
    ok = np.ones((len(p), len(q)), bool)
    off = one.off + two.off if relaxed else 0.0
    x_off = one.x_off + two.x_off + one.radius * one.yaw_off + two.radius * two.yaw_off if relaxed else 0.0
    y_off = one.y_off + two.y_off + one.radius * one.yaw_off + two.radius * two.yaw_off if relaxed else 0.0
    names = {one.thing.name, two.thing.name}
    rules = [r for r in problem.relations if set(r.things) == names and r.kind not in JOINT]
    lines = [r for r in problem.relations if r.kind == "in_line" and names <= set(r.things)]
    (low, high), (base, top) = one.heights_m, two.heights_m
    gap = problem.clearance_m if low < top and base < high else -np.inf  # of different heights: none
    for a in np.unique(p[:, 2]):
        for b in np.unique(q[:, 2]):
            rows, columns = np.flatnonzero(p[:, 2] == a), np.flatnonzero(q[:, 2] == b)
            ring, other = one.ring(a), two.ring(b)
            steps = q[columns][None, :, :2] - p[rows][:, None, :2]
            unique, back = np.unique(np.round(steps.reshape(-1, 2), 9), axis=0, return_inverse=True)
            distance = _signed(unique, _difference(ring, other))
            fine = distance >= gap - off - NOISE
            for rule in lines:
                fine &= _in_line_pair(rule, unique, one, two, relaxed)
            for rule in rules:
                swapped = rule.things[0] == two.thing.name
                fine &= _holds(rule, unique, distance, ring, other, a, b, swapped, off, x_off, y_off, one, two, relaxed)
            ok[np.ix_(rows, columns)] = fine[back.ravel()].reshape(len(rows), len(columns))
    return ok


def _holds(rule: SceneRelation, steps, distance, ring, other, a, b, swapped, off, x_off, y_off, one, two, relaxed):
    sign = -1.0 if swapped else 1.0
    first, second = (other, ring) if swapped else (ring, other)
    direction = np.array(rule.direction)
    if rule.kind == "before":
        along = abs(direction[0]) * x_off + abs(direction[1]) * y_off
        gap = sign * steps @ direction + (second @ direction).min() - (first @ direction).max()
        return gap >= rule.gap_m - along - NOISE
    if rule.kind == "above":
        upper, lower = (two, one) if swapped else (one, two)
        return np.full(len(steps), upper.heights_m[0] >= lower.heights_m[1] + rule.gap_m - NOISE)
    if rule.kind == "near":
        return distance <= rule.gap_m + off + NOISE
    if rule.kind == "far_from":
        return distance >= rule.gap_m - off - NOISE
    if rule.kind == "aligned":
        across = np.array([-direction[1], direction[0]])
        slack = abs(across) @ [one.x_off + two.x_off, one.y_off + two.y_off] if relaxed else 0.0
        return abs(steps @ across) <= rule.tolerance + slack + NOISE
    if rule.kind == "facing":
        toward = sign * steps
        angle = np.arctan2(toward[:, 1], toward[:, 0]) - (b if swapped else a)
        angle = abs((angle + np.pi) % (2 * np.pi) - np.pi)
        length = np.hypot(*steps.T)
        slip = np.hypot(one.x_off + two.x_off, one.y_off + two.y_off) if relaxed else 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(length > slip, np.arcsin(np.clip(slip / length, 0, 1)), np.pi) if relaxed else 0.0
        yaw_off = (two if swapped else one).yaw_off if relaxed else 0.0
        return angle <= rule.tolerance + turn + yaw_off + NOISE
    raise ValueError(rule.kind)


def _search(masks, allowed, done, poses, grids, joint, index, relaxed) -> bool:
    """Depth first over things, the one with fewest poses left first; what is open at last is settled by one look."""
    open_things = [k for k in range(len(masks)) if k not in [d for d, _ in done]]
    if any(not masks[k].any() for k in open_things):
        return False
    if not open_things:
        return True
    if len(open_things) == 2 and not joint:
        a, b = open_things
        return bool(allowed[a, b][np.ix_(masks[a], masks[b])].any())
    k = min(open_things, key=lambda k: masks[k].sum())
    if len(open_things) == 1:
        rows = np.flatnonzero(masks[k])
        at = {m: poses[m][None, pose, :2] for m, pose in done} | {k: poses[k][rows, :2]}
        return bool(np.all([_joint(r, at, grids, index, relaxed) for r in joint], axis=0).any()) if joint else True
    for pose in np.flatnonzero(masks[k]):
        left = list(masks)
        for m in open_things:
            if m != k:
                row = allowed[k, m][pose] if k < m else allowed[m, k][:, pose]
                left[m] = masks[m] & row
        if _search(left, allowed, [*done, (k, pose)], poses, grids, joint, index, relaxed):
            return True
    return False


def _joint(rule: SceneRelation, at: dict[int, np.ndarray], grids, index, relaxed: bool) -> np.ndarray:
    """(m,) whether a relation of origins holds; `at` are origins (m, 2), or (1, 2) where all are the same."""
    numbers = [index[name] for name in rule.things]
    points = np.stack(np.broadcast_arrays(*(at[k] for k in numbers)))
    slips = np.array([[grids[k].x_off, grids[k].y_off] for k in numbers]) if relaxed else np.zeros((len(numbers), 2))
    if rule.kind == "between":
        return _between(rule, points, slips, relaxed)
    if rule.kind == "surrounding":
        return _surrounding(rule, points, slips)
    steps = np.diff(points, axis=0)
    return np.all([_in_line_step(rule, s, slips[k] + slips[k + 1], 1) for k, s in enumerate(steps)], axis=0) & (
        np.ptp(points @ [-rule.direction[1], rule.direction[0]], axis=0)
        <= rule.tolerance + 2.0 * (slips @ np.abs([-rule.direction[1], rule.direction[0]])).max() + NOISE
    )


def _in_line_pair(rule: SceneRelation, steps: np.ndarray, one: Grid, two: Grid, relaxed: bool) -> np.ndarray:
    """(n,) whether two members may be so many steps apart, each in its own direction from the first."""
    count = rule.things.index(two.thing.name) - rule.things.index(one.thing.name)
    slip = np.array([one.x_off + two.x_off, one.y_off + two.y_off]) if relaxed else np.zeros(2)
    across = np.array([-rule.direction[1], rule.direction[0]])
    aside = abs(steps @ across) <= rule.tolerance + slip @ abs(across) + NOISE
    return aside & _in_line_step(rule, steps if count > 0 else -steps, slip, abs(count))


def _in_line_step(rule: SceneRelation, steps: np.ndarray, slip: np.ndarray, count: int) -> np.ndarray:
    direction = np.array(rule.direction)
    along, off = steps @ direction, slip @ abs(direction) + NOISE
    if rule.gap_m <= 0.0:
        return along >= -off
    return abs(along - count * rule.gap_m) <= count * rule.tolerance + off


def _surrounding(rule: SceneRelation, points: np.ndarray, slips: np.ndarray) -> np.ndarray:
    assert rule.angle_rad is not None
    least, most = rule.angle_rad
    steps = points[1:] - points[:1]
    length, slip = np.hypot(steps[..., 0], steps[..., 1]), np.hypot(*(slips[1:] + slips[:1]).T)[:, None]
    swing = np.where(length > slip, np.arcsin(np.clip(slip / np.maximum(length, 1e-9), 0.0, 1.0)), np.pi).max(axis=0)
    headings = np.sort(np.arctan2(steps[..., 1], steps[..., 0]), axis=0)
    angles = np.concatenate([np.diff(headings, axis=0), headings[:1] + 2.0 * np.pi - headings[-1:]])
    has_directions = (length > 1e-3).all(axis=0) | (slip > 0.0).all()
    fine = (angles.min(axis=0) + 2.0 * swing >= least - NOISE) & (angles.max(axis=0) - 2.0 * swing <= most + NOISE)
    return has_directions & fine


def _between(rule: SceneRelation, points: np.ndarray, slips: np.ndarray, relaxed: bool) -> np.ndarray:
    a, b, c = points
    line, step = c - b, a - b
    length = np.hypot(*line.T)
    slip = 2.0 * np.hypot(*slips.T).max()
    safe = np.maximum(length, 1e-9)
    past = (step * line).sum(axis=1) / safe
    beside = abs(step[:, 0] * line[:, 1] - step[:, 1] * line[:, 0]) / safe
    # A turn of the line by both its ends moves what is beside it by as much as the ends move, within its length.
    near = (
        (past >= -2 * slip - NOISE)
        & (past <= length + 2 * slip + NOISE)
        & (beside <= rule.tolerance + 2 * slip + NOISE)
    )
    return np.where(length <= 2 * slip, True, near) if relaxed else near & (length >= 1e-6)
