"""Draw scenes from the tables of a plan, many at once, as arrays (m, rad). Needs numpy and `schemas` alone.

A sample's numbers depend on seed and index alone (`runtime_plan.counter_rng`), in this order: combination, case of
each pool, body of each thing, yaw, x and y of each thing, a material of each group, lighting and its channels, number
of the distractors that are present and the first of them, height of the background.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from runtime_plan.backend import NUMPY, Backend
from runtime_plan.plan import Plan
from runtime_plan.portable_trig import half_angle
from runtime_plan.samples import Samples
from runtime_plan.tables import ABSENT, AUTHORED, BodyStances, CombinationTables, DrawLayout, Outlines, PlanTables, Pool

Array = Any
CHUNK = 512  # samples worked on at once, so that their numbers stay in the processor's cache


def sample(plan: Plan, n: int, seed: int, start: int = 0) -> Samples:
    """Samples `start` to `start + n - 1` of the stream `seed`, valid by construction; any split gives the same."""
    return sample_with(NUMPY, plan.tables, n, seed, start, CHUNK)


def sample_with(backend: Backend, tables: PlanTables, n: int, seed: int, start: int, chunk: int) -> Samples:
    """As `sample`, in chunks, with the arrays of `backend`; `tables` hold arrays of the same library."""
    if n < 0 or start < 0 or not 0 <= seed < 2**64:
        raise ValueError(f"n and start are at least 0, seed is from 0 to 2**64 - 1: {n}, {start}, {seed}")
    samples = _empty(backend, tables, n, seed, start)
    for low in range(0, n, chunk):
        high = min(n, low + chunk)
        u = backend.uniforms(seed, start + low, high - low, tables.layout.blocks)
        _fill(backend, samples, slice(low, high), tables, u)
    return samples


def _empty(backend: Backend, tables: PlanTables, n: int, seed: int, start: int) -> Samples:
    things, pools, full = len(tables.names), tables.layout.bodies - tables.layout.cases, backend.full
    return Samples(
        seed=seed,
        start=start,
        names=tables.names,
        combination=full((n,), 0),
        case=full((n, pools), -1),
        present=full((n, things), False),
        asset_index=full((n, things), -1),
        stance=full((n, things), 0),
        support=full((n, things), ABSENT),
        position_m=full((n, things, 3), np.nan),
        quat_wxyz=full((n, things, 4), np.nan),
        yaw_rad=full((n, things), np.nan),
        material=full((n, things), AUTHORED),
        background_material=full((n,), AUTHORED),
        background=full((n,), -1),
        lighting=full((n,), -1),
        channels=full((n, 4), np.nan),
        rise_m=full((n,), 0.0),
    )


def _fill(backend: Backend, samples: Samples, chunk: slice, tables: PlanTables, u: Array) -> None:
    """Draw the samples of a chunk, one combination after the other."""
    if len(tables.combinations) == 1:
        _draw(backend, samples, chunk, tables, 0, u)
        return
    chosen = backend.xp.searchsorted(tables.cumulative_shares, u[:, 0], side="right")
    samples.combination[chunk] = chosen
    for index in range(len(tables.combinations)):
        nonzero: Array = (chosen == index).nonzero()
        rows: Array = cast(tuple[Array], nonzero)[0] if isinstance(nonzero, tuple) else nonzero[:, 0]
        if len(rows):
            _draw(backend, samples, rows + chunk.start, tables, index, u[rows])


def _draw(backend: Backend, samples: Samples, rows: Any, plan: PlanTables, index: int, u: Array) -> None:
    """Draw `rows`, all of one combination, into `samples`."""
    tables, layout, body_stances = plan.combinations[index], plan.layout, plan.body_stances
    things = len(tables.first_row)
    columns = slice(None) if tables.all_things else tables.things
    # Rows x columns of the result.
    at: Array = cast(Array, rows) if isinstance(rows, slice) or tables.all_things else rows[:, None]
    cases = _cases(backend, tables.pools, u[:, layout.cases :])
    table_rows = (cases if tables.one_thing_per_pool else cases[:, tables.pool_of]) + tables.first_row
    bodies, stance, body_stance = _bodies_and_stances(backend, tables, layout, body_stances, table_rows, u)
    yaw = _yaw(backend, tables, table_rows, u[:, layout.yaws : layout.yaws + things])
    c, s = half_angle(backend.xp, yaw)
    x, y = _origin(backend, tables, table_rows, body_stance, c, s, u[:, layout.xs :], u[:, layout.ys :])
    z = _pick(backend, tables.height_m, table_rows) + _pick(backend, body_stances.origin_height_m, body_stance)
    _to_world(tables, x, y, z, c, s)
    if tables.rise_m > 0.0:
        rise = u[:, layout.rise] * tables.rise_m
        samples.rise_m[rows] = rise
        z = z + rise[:, None]
    quat_wxyz = _quaternion(backend, body_stances, body_stance, c, s)
    if tables.shown is not None:
        bodies, stance, yaw, x, y, z = (part[..., tables.shown] for part in (bodies, stance, yaw, x, y, z))
        quat_wxyz = tuple(part[..., tables.shown] for part in quat_wxyz)
    samples.case[rows, : len(tables.pools)] = cases
    samples.present[at, columns] = True
    samples.asset_index[at, columns] = bodies
    samples.stance[at, columns] = stance
    samples.support[at, columns] = tables.support
    samples.yaw_rad[at, columns] = yaw
    for axis, values in enumerate((x, y, z)):
        samples.position_m[at, columns, axis] = values
    for axis, values in enumerate(quat_wxyz):
        samples.quat_wxyz[at, columns, axis] = values
    samples.background[rows] = tables.background_body
    _materials_and_lighting(backend, samples, rows, at, columns, plan, tables, u)
    _leave_out(backend, samples, rows, plan.layout, tables, u)


def _pick(backend: Backend, values: Array, index: Array) -> Array:
    return backend.xp.take(values, index)


def _cases(backend: Backend, pools: tuple[Pool, ...], u: Array) -> Array:
    """(m, P) case of each pool."""
    cases = backend.full((len(u), len(pools)), 0)
    for p, pool in enumerate(pools):
        if pool.cumulative_shares is not None:
            cases[:, p] = backend.xp.searchsorted(pool.cumulative_shares, u[:, p], side="right")
        elif pool.count > 1:
            cases[:, p] = backend.floor_to_int(u[:, p] * pool.count)
    return cases


def _bodies_and_stances(
    backend: Backend, tables: CombinationTables, layout: DrawLayout, body_stances: BodyStances, rows: Array, u: Array
) -> tuple[Array, Array, Array]:
    """Body, stance and index in `BodyStances` of each thing: (m, T), or (T,) where they never change."""
    if tables.body_stance is not None:
        return tables.bodies[:, 0], tables.fixed_stance, tables.body_stance
    stance = _pick(backend, tables.stance, rows)
    if tables.bodies.shape[1] == 1:
        bodies = tables.bodies[:, 0]
    else:
        drawn = backend.floor_to_int(u[:, layout.bodies : layout.bodies + len(tables.first_row)] * tables.body_count)
        bodies = _pick(backend, tables.bodies, drawn + tables.body_row)
    return bodies, stance, _pick(backend, body_stances.start, bodies) + stance


def _yaw(backend: Backend, tables: CombinationTables, rows: Array, u: Array) -> Array:
    """(m, T) uniform over the intervals of each row."""
    along = u * _pick(backend, tables.yaw_span_rad[1], rows)
    yaw = along + _pick(backend, tables.yaw_span_rad[0], rows)
    for gap_at, gap in zip(tables.yaw_gap_at_rad, tables.yaw_gap_rad, strict=True):
        yaw += (along >= _pick(backend, gap_at, rows)) * _pick(backend, gap, rows)
    return yaw


def _origin(
    backend: Backend,
    tables: CombinationTables,
    rows: Array,
    body_stance: Array,
    c: Array,
    s: Array,
    ux: Array,
    uy: Array,
) -> tuple[Array, Array]:
    """x and y (m, T) of the asset origin in A: uniform where the footprint at its yaw stays in its cell."""
    things = c.shape[1]
    cosine = 1.0 - 2.0 * s * s
    sine = 2.0 * s * c
    footprint = _footprint_bounds(backend, tables.outlines, body_stance, cosine, sine)
    origin: list[Array] = []
    for axis, u in enumerate((ux, uy)):
        bounds, (least, most) = tables.bounds_m[2 * axis :], footprint[axis]
        low = _pick(backend, bounds[0], rows) - least
        high = _pick(backend, bounds[1], rows) - most
        if tables.has_origin_boxes:
            low = backend.xp.maximum(low, _pick(backend, bounds[4], rows))
            high = backend.xp.minimum(high, _pick(backend, bounds[5], rows))
        high -= low
        high *= u[:, :things]
        low += high
        origin.append(low)
    return origin[0], origin[1]


def _footprint_bounds(
    backend: Backend, outlines: tuple[Outlines, ...], body_stance: Array, cosine: Array, sine: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Least and most x, least and most y (m, T) indices the outlines, turned about the asset origin."""
    xp = backend.xp
    if len(outlines) == 1:
        return _bounds_of(xp, outlines[0], body_stance, cosine, sine)
    bounds = backend.full((4, *cosine.shape), 0.0)
    for outline in outlines:
        columns = outline.columns
        indices = body_stance if body_stance.ndim == 1 else body_stance[:, columns]
        outline_bounds = _bounds_of(xp, outline, indices, cosine[:, columns], sine[:, columns])
        for k, values in enumerate((*outline_bounds[0], *outline_bounds[1])):
            bounds[k][:, columns] = values
    return (bounds[0], bounds[1]), (bounds[2], bounds[3])


def _bounds_of(
    xp: Any, outline: Outlines, body_stance: Array, cosine: Array, sine: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    lowest_x = highest_x = lowest_y = highest_y = None
    for corner_x, corner_y in zip(outline.x_m, outline.y_m, strict=True):
        px = corner_x if outline.fixed else xp.take(corner_x, body_stance)
        py = corner_y if outline.fixed else xp.take(corner_y, body_stance)
        x = cosine * px
        x -= sine * py
        y = sine * px
        y += cosine * py
        if lowest_x is None:
            lowest_x, highest_x, lowest_y, highest_y = x, x, y, y
        else:
            lowest_x, highest_x = xp.minimum(lowest_x, x), xp.maximum(highest_x, x)
            lowest_y, highest_y = xp.minimum(lowest_y, y), xp.maximum(highest_y, y)
    return (lowest_x, highest_x), (lowest_y, highest_y)


def _to_world(tables: CombinationTables, x: Array, y: Array, z: Array, c: Array, s: Array) -> None:
    """Transform poses (m, T) from A of each thing's place to W, in place; owners are level.

    `c`, `s` are cosine and sine of half the yaw; `z` is already a height in U of the owner.
    """
    x += tables.place_m[0]
    y += tables.place_m[1]
    for level in tables.levels:
        if level.owners is None:
            at_x, at_y, at_z, c_W, s_W = tables.background
        else:
            owners = level.owners
            at_x, at_y, at_z, c_W, s_W = x[:, owners], y[:, owners], z[:, owners], c[:, owners], s[:, owners]
        columns = slice(None) if level.columns is None else level.columns
        if level.owners is None and tables.background == (0.0, 0.0, 0.0, 1.0, 0.0):
            continue
        cosine, sine = 1.0 - 2.0 * s_W * s_W, 2.0 * s_W * c_W
        x_U, y_U, c_U, s_U = x[:, columns], y[:, columns], c[:, columns], s[:, columns]
        x[:, columns], y[:, columns] = at_x + cosine * x_U - sine * y_U, at_y + sine * x_U + cosine * y_U
        c[:, columns], s[:, columns] = c_W * c_U - s_W * s_U, s_W * c_U + c_W * s_U
        z[:, columns] += at_z


def _quaternion(
    backend: Backend, body_stances: BodyStances, body_stance: Array, c: Array, s: Array
) -> tuple[Array, Array, Array, Array]:
    """The product of yaw and stance quaternions, (m, T) each of w, x, y, z."""
    w, x, y, z = (_pick(backend, part, body_stance) for part in body_stances.quat_wxyz)
    return c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w


def _materials_and_lighting(
    backend: Backend,
    samples: Samples,
    rows: Any,
    at: Any,
    columns: Any,
    plan: PlanTables,
    tables: CombinationTables,
    u: Array,
) -> None:
    """Draw the materials and the lighting of `rows`."""
    for k, group in enumerate(tables.groups):
        material_of = group.material_of[backend.floor_to_int(u[:, plan.layout.materials + k] * len(group.material_of))]
        samples.material[at, columns] = backend.xp.maximum(samples.material[at, columns], material_of[:, :-1])
        samples.background_material[rows] = backend.xp.maximum(samples.background_material[rows], material_of[:, -1])
    if len(tables.lighting):
        lighting = tables.lighting[backend.floor_to_int(u[:, plan.layout.lighting] * len(tables.lighting))]
        bounds = plan.channels[lighting]
        drawn = u[:, plan.layout.lighting + 1 : plan.layout.lighting + 5]
        samples.lighting[rows] = lighting
        samples.channels[rows] = bounds[..., 0] + drawn * (bounds[..., 1] - bounds[..., 0])


def _leave_out(
    backend: Backend, samples: Samples, rows: Any, layout: DrawLayout, tables: CombinationTables, u: Array
) -> None:
    """Take out the distractors of `rows` beyond the number drawn: those that follow on the first one, in a circle."""
    for k, optional in enumerate(tables.optional):
        count, drawn = len(optional.columns), u[:, layout.optional + 2 * k : layout.optional + 2 * k + 2]
        present = optional.least + backend.floor_to_int(drawn[:, :1] * (optional.most - optional.least + 1))
        first = backend.floor_to_int(drawn[:, 1:] * count)
        absent = (optional.numbers[None, :] + first) % count >= present
        for array, value in _absent_values(samples):
            part = array[rows][:, optional.columns]
            part[absent] = value
            at: Any = (rows, optional.columns) if isinstance(rows, slice) else (rows[:, None], optional.columns)
            array[at] = part


def _absent_values(samples: Samples) -> tuple[tuple[Array, float | int | bool], ...]:
    return (
        (samples.present, False), (samples.asset_index, -1), (samples.stance, 0), (samples.support, ABSENT),
        (samples.position_m, np.nan), (samples.quat_wxyz, np.nan), (samples.yaw_rad, np.nan),
        (samples.material, AUTHORED),
    )  # fmt: skip
