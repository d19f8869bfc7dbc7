"""The lists of tosses: boxes that fly or slide, or tumble, with a cause, level and log by a rule from a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import HiddenInBox, move
from tests.suites.gap2.generate.cases import SEED, CaseFiles, family_of, turn_of
from tests.suites.gap2.generate.power import LEVELS, strength_for
from tests.suites.gap2.generate.tosses.causes import (
    LIBRARY,
    OUTSIDE,
    PAIRS,
    TUMBLE_LIBRARY,
    TUMBLE_OUTSIDE,
    TWINS,
    TossCause,
)
from tests.suites.gap2.generate.tosses.files import toss_files
from tests.suites.gap2.generate.tosses.recording import TrackedToss, draw_toss, draw_tumble
from tests.suites.gap2.generate.tosses.rivals import labelled
from tests.suites.gap2.generate.truth import Family, HiddenEffect, Truth

_HORIZON_S = 0.1
_CONTROLS = ("none", "nuisance", "noise")


def toss_case(number: int) -> CaseFiles:
    """The toss of that number; the same number gives the same bytes."""
    family, turn = family_of(number), turn_of(number)
    rng = np.random.default_rng([SEED, 1, number])
    causes, slides, level, control = _chosen(family, turn)
    draft = _made(number, causes, level, control, draw_toss(slides, rng), rng)
    tracked, readings = draft.tracked, draft.readings
    truth = replace(draft.truth, scene="slide" if slides else "flight")
    truth = labelled(truth, tracked, readings) if len(causes) == 1 else truth
    return toss_files(truth, tracked, readings, rng)


def tumble_case(number: int) -> CaseFiles:
    """The tumbling box of that number. Its causes have no equals: refits through contacts would not find these.

    Families are those of all lists; where a family needs equals, a single effect is hidden.
    """
    family, turn = family_of(number), turn_of(number)
    rng = np.random.default_rng([SEED, 2, number])
    causes, level, control = [], "", ""
    if family == "control":
        control = _CONTROLS[turn % len(_CONTROLS)]
    else:
        some = TUMBLE_OUTSIDE if family == "outside" else TUMBLE_LIBRARY
        family = family if family in ("outside", "left_out") else "single"
        causes, level = [some[turn % len(some)]], ("gross", "large")[turn // len(some) % 2]
    draft = _made(number, causes, level, control, draw_tumble(rng), rng)
    return toss_files(replace(draft.truth, family=family, scene="tumble"), draft.tracked, draft.readings, rng)


@dataclass(frozen=True)
class _Made:
    """A case before its files: the toss, what it shows (r, rows, 13), and its truth without equals."""

    tracked: TrackedToss
    readings: Array
    truth: Truth


def _made(
    number: int, causes: Sequence[TossCause], level: str, control: str, tracked: TrackedToss, rng: np.random.Generator
) -> _Made:
    """Causes at the strength of their level."""
    family, way = family_of(number), _way(rng)
    if control == "noise":
        tracked = replace(tracked, sigma_m=5.0 * tracked.sigma_m, sigma_rad=5.0 * tracked.sigma_rad)
    actual = tracked.box
    if control == "nuisance":
        off = rng.uniform(0.97, 1.03, 2)
        actual = replace(actual, mass_kg=actual.mass_kg * off[0], mu=actual.mu * off[1])
    hidden, effects, reached = HiddenInBox(), [], True
    for cause in causes:
        strength, cause_reached = strength_for(
            lambda s, cause=cause: tracked.miss(
                move(tracked.box, cause.make(s, way, tracked.box), tracked.t_s, tracked.start), _HORIZON_S
            ),
            LEVELS[level],
            1e-4,
            cause.most,
        )
        one = cause.make(strength, way, tracked.box)
        hidden = hidden.beside(one)
        reached = reached and cause_reached
        effects.append(HiddenEffect(cause.name, "", dict(cause.checked(one)), strength))
    readings = move(actual, hidden, tracked.t_s, tracked.start)
    truth = Truth(
        number,
        "",
        family,
        "free_body",
        "",
        tuple(effects),
        level=level,
        level_reached=reached,
        miss=tracked.miss(readings, _HORIZON_S),
        miss_whole=tracked.miss(readings, float("inf")),
        horizon_s=_HORIZON_S,
        sigma=tracked.sigma_m,
        left_out=(causes[0].name,) if family == "left_out" else (),
        control=control,
    )
    return _Made(tracked, readings, truth)


def _chosen(family: Family, turn: int) -> tuple[list[TossCause], bool, str, str]:
    """(causes, slides, level, kind of control)."""
    levels = ("gross", "large")
    if family == "control":
        return [], bool(turn % 2), "", _CONTROLS[turn // 2 % len(_CONTROLS)]
    if family == "outside":
        cause = OUTSIDE[turn % len(OUTSIDE)]
        return [cause], bool(cause.slides), levels[turn // len(OUTSIDE) % 2], ""
    by_name = {c.name: c for c in LIBRARY}
    if family == "two":
        first, second, slides = PAIRS[turn % len(PAIRS)]
        return [by_name[first], by_name[second]], slides, levels[turn // len(PAIRS) % 2], ""
    if family == "twin":
        name, slides = TWINS[turn % len(TWINS)]
        return [by_name[name]], slides, levels[turn // len(TWINS) % 2], ""
    cause = LIBRARY[(turn * 2 + (family == "left_out")) % len(LIBRARY)]
    slides = bool(turn % 2) if cause.slides is None else cause.slides
    return [cause], slides, levels[(turn + turn // len(LIBRARY)) % 2], ""


def _way(rng: np.random.Generator) -> Array:
    way = rng.normal(size=3)
    return way / np.linalg.norm(way)
