"""Candidate effects of a free body with bounds from its shapes, its motion and direct estimates; SI."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from schemas.gap import Place
from schemas.physical_constants import GRAVITY_MPS2
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Effect, Series
from sim.effects.library import EFFECTS, effect
from simgap.kinds.free_body.direct_estimates import agree_on_one_value
from simgap.problem import Candidate, DirectEstimate

# Declared numbers are believed to this share; what lies within is a nuisance, not an effect.
TOLERANCE = 0.05
# Two engines, and sliding and impacts in one, differ by this much about the friction of a pair.
FRICTION_TOLERANCE = 0.15
# Contacts begin and end at steps of the engine and in another order: slopes over less are those of single jumps.
CONTACT_STEP, _NUISANCE_STEP = 0.02, 0.2
_COARSEST = 0.2
BOUNDS_ALPHA = 0.01  # level at which a direct estimate sets the bounds or replaces a fit
_BEYOND = 0.25  # share of a direct estimate above that level by which bounds exceed it
_SEEN, _LITTLE_OF_BOUNDS = 0.05, 0.02  # level of "something is there"; share of the bounds that is little
_NEED_SUPPORT = ("contact", "body.size")
_NEED_JOINTS = ("joint", "sensor.bias")
DIRECTLY_MEASURED = (
    "body.size",
    "world.gravity_magnitude",
    "sensor.scale",
    "sensor.clock_skew",
    "sensor.velocity_age",
)


def candidates_of(
    model: BodyModel,
    series: Sequence[Series],
    estimate_directly: Callable[[Candidate], DirectEstimate | None] | None = None,
) -> tuple[Candidate, ...]:
    """Every effect of the library that poses of a free body can reveal, in library order.

    An effect whose direct estimate is clearly zero is left out; bounds of the others stay near their direct estimates,
    because fits to contacts stray.
    """
    out = []
    for each in EFFECTS:
        if "free_body" not in each.kinds or not _observable(each, model):
            continue
        null = each.null() | declared_of(each.name, model)
        table = bounds_of(model, series)
        bounds = {p.name: table.get((each.name, p.name), (p.low, p.high)) for p in each.parameters}
        start = {n: float(np.clip(v, *bounds[n])) for n, v in null.items()}
        wide = Candidate(each, _where(each), null, start, bounds, step=CONTACT_STEP)
        direct = estimate_directly(wide) if estimate_directly else None
        if direct is None:
            out.append(wide)
        elif not absent(wide, direct):
            out.append(with_direct_bounds(wide, direct) if each.name in DIRECTLY_MEASURED else wide)
    return tuple(out)


def absent(wide: Candidate, direct: DirectEstimate) -> bool:
    """Whether the direct estimate sees nothing, and would see a small share of what is possible.

    Of several readings that contradict one another one is enough: what shrinks at rest and not in falls is no scale.
    """
    if direct.separate_readings:
        unseen = [absent(wide, one) for one in direct.separate_readings]
        return all(unseen) or (any(unseen) and not agree_on_one_value(direct.separate_readings))
    if direct.p_value < _SEEN:
        return False
    return all(
        abs(direct.values[n] - wide.null[n]) + 2.0 * direct.standard_errors[n] < _LITTLE_OF_BOUNDS * (high - low)
        for n, (low, high) in wide.bounds.items()
    )


def nuisances_of(model: BodyModel) -> tuple[Candidate, ...]:
    """Declared friction and bounce of the pair within their tolerance."""
    out = []
    for name, parameter, value, half in (
        ("contact.friction", "mu", model.friction, FRICTION_TOLERANCE * model.friction),
        ("contact.restitution", "restitution", model.restitution, TOLERANCE),
    ):
        if model.has_support and half > 0.0:
            one = {parameter: value}
            low, high = max(0.0, value - half), min(1.5, value + half)
            out.append(
                Candidate(
                    effect(name),
                    Place(pair="body-support"),
                    one,
                    one,
                    {parameter: (low, high)},
                    True,
                    step=_NUISANCE_STEP,
                )
            )
    return tuple(out)


def with_direct_bounds(wide: Candidate, direct: DirectEstimate) -> Candidate:
    """The candidate with bounds from no effect to the direct estimate, and beyond both no further than that errs.

    Fits to contacts stray: one that ends at such a bound is as sure as the estimate that set it, if that is sure at
    all; where it is not, bounds lie a little further.
    """
    bounds, half_widths, step = {}, {}, wide.step
    sure = direct.p_value < BOUNDS_ALPHA
    for name, (low, high) in wide.bounds.items():
        null, value = wide.null[name], direct.values[name]
        beyond = 4.0 * direct.standard_errors[name] + 0.002 * (high - low)
        if not sure:
            beyond += _BEYOND * abs(value - null)
        bounds[name] = (max(low, min(null, value) - beyond), min(high, max(null, value) + beyond))
        if bounds[name][0] >= bounds[name][1]:
            return wide
        if sure:
            half_widths[name] = beyond
        step = min(_COARSEST, wide.step * (high - low) / (bounds[name][1] - bounds[name][0]))
    return replace(wide, bounds=bounds, direct_half_width=half_widths, step=step)


def _observable(each: Effect, model: BodyModel) -> bool:
    if not model.has_support and each.name.startswith(_NEED_SUPPORT):
        return False
    if each.name.startswith(_NEED_JOINTS):
        return False
    # A passive body shows its mass only through forces that do not scale with it.
    return each.name != "body.mass"


def _where(each: Effect) -> Place:
    if each.family == "contact":
        return Place(pair="body-support")
    return Place(body="body") if each.family == "body" else Place()


def declared_of(name: str, model: BodyModel) -> dict[str, float]:
    """Parameter values that the subject declares."""
    g = float(np.linalg.norm(model.gravity_W))
    com = {f"{axis}_m": float(v) for axis, v in zip("xyz", model.com_B, strict=True)}
    return {
        "contact.friction": {"mu": model.friction},
        "contact.restitution": {"restitution": model.restitution},
        "body.com_offset": com,
        "world.gravity_magnitude": {"gravity_mps2": g},
    }.get(name, {})


def bounds_of(model: BodyModel, series: Sequence[Series]) -> dict[tuple[str, str], tuple[float, float]]:
    """Bounds that follow from the body's size and speed: forces up to half its weight, offsets up to a third of it."""
    g = float(np.linalg.norm(model.gravity_W)) or GRAVITY_MPS2
    speed = max(
        float(np.quantile(np.concatenate([np.linalg.norm(s.columns["v_W"], axis=1) for s in series]), 0.95)), 0.1
    )
    corners = np.concatenate([_extent(shape) for shape in model.shapes])
    size = float(np.ptp(corners, axis=0).max())
    weight = model.mass_kg * g
    table: dict[tuple[str, str], tuple[float, float]] = {
        ("contact.friction", "mu"): (0.0, 1.5),
        ("contact.rolling_friction", "lever_m"): (0.0, 0.2 * size),
        ("contact.spinning_friction", "lever_m"): (0.0, 0.2 * size),
        ("contact.anisotropic_friction", "ratio"): (0.1, 5.0),
        ("contact.compliance", "stiffness_Npm"): (weight / (0.1 * size), weight / (1e-4 * size)),
        ("contact.compliance", "damping_Nspm"): (0.0, 4.0 * model.mass_kg * np.sqrt(g / (1e-3 * size))),
        ("body.inertia", "factor"): (0.3, 3.0),
        ("body.size", "factor"): (0.7, 1.4),
        ("world.gravity_magnitude", "gravity_mps2"): (0.5 * g, 1.5 * g),
        ("world.linear_drag", "drag_Nspm"): (0.0, weight / speed),
        ("world.quadratic_drag", "drag_Ns2pm2"): (0.0, weight / speed**2),
        ("sensor.scale", "factor"): (0.7, 1.4),
        ("sensor.clock_skew", "factor"): (0.7, 1.4),
    }
    for axis, centre in zip("xyz", model.com_B, strict=True):
        table[("body.com_offset", f"{axis}_m")] = (float(centre) - size / 3.0, float(centre) + size / 3.0)
        table[("world.constant_force", f"{axis}_N")] = (-0.5 * weight, 0.5 * weight)
    return table


def _extent(shape) -> np.ndarray:
    """Corners (n, 3) that bound a shape."""
    if shape.points is not None:
        return shape.points
    half = 0.5 * np.array([*shape.size_m, *shape.size_m])[:3]
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return (signs * half) @ shape.X_AS[:3, :3].T + shape.X_AS[:3, 3]
