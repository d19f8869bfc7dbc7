"""Which library effects explain a hidden cause as well as itself: best refits, by the power of their difference.

Starts of segments are free, believed numbers are free within their tolerance, and the rival's own parameters are free
(Gauss-Newton, Jacobians by differences). What is left, summed in squared noise levels, is the noncentrality of a
likelihood ratio test between the two over all trials: below `SAME` these data cannot separate them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tests.suites.gap2.generate.causes.cause import Where
from tests.suites.gap2.generate.causes.library import LIBRARY
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant, Trial
from tests.suites.gap2.generate.power import Readings, miss_by_trial
from tests.suites.gap2.generate.refit import Make, Refit, Values
from tests.suites.gap2.generate.scenes import Recording
from tests.suites.gap2.generate.truth import CLOSE

_TRIALS, _MOTION_S = 3, 6.0  # so many trials, and so long a motion (s), those that a cause moves most
_FIRST_MISS, _LEAST_SHARE = 5.0, 1e-3  # noise levels of a whole trial at the first share of the strength
_GROWTH = 3.0  # of that share from refit to refit
_LOST = 1e4  # noncentrality of belief beyond which its refit is followed no further

ReadingsAt = Callable[[float, Sequence[Trial]], Readings]


@dataclass(frozen=True)
class Rival:
    """What a rival leaves: its noncentrality beside the hidden cause, over all trials."""

    name: str
    noncentrality: float


def rivals_of(
    truth: Sequence[str], where: Where, recording: Recording, readings_at: ReadingsAt
) -> tuple[float, tuple[Rival, ...]]:
    """(noncentrality of the believed model after its own refit, promising rivals, nearest first).

    `readings_at` gives the noise-free readings of some trials with a share of the hidden strength. Refits begin at a
    share so small that a linear model holds and follow it to the whole, each from the one before; a refit that is
    separable on the way stays so, and its noncentrality there is a lower bound.
    """
    strong = miss_by_trial(
        where.plant,
        readings_at(1.0, recording.trials),
        recording.trials,
        recording.sigma,
        float("inf"),
        recording.step_s,
    )
    order = np.argsort(-strong, kind="stable")
    lengths = np.cumsum([float(np.ptp(recording.trials[i].stamps_s)) for i in order])
    some = sorted(order[: max(_TRIALS, int(np.searchsorted(lengths, _MOTION_S)) + 1)].tolist())
    all_trials = float(strong.sum() / max(strong[some].sum(), 1e-12))
    trials = [recording.trials[i] for i in some]
    rows = sum(len(t.stamps_s) for t in trials) * where.plant.joints
    first = float(np.clip(_FIRST_MISS / max(np.sqrt(strong[some].sum() / rows), 1e-9), _LEAST_SHARE, 1.0))

    def at(share: float) -> Refit:
        return Refit(where, trials, readings_at(share, trials), recording, all_trials, share)

    believed: Make = lambda plant, x: Hidden(where.joint)  # noqa: E731
    count = int(np.ceil(np.log(1.0 / first) / np.log(_GROWTH) - 1e-9)) + 1
    stages = [at(min(1.0, first * _GROWTH**k)) for k in range(count)]
    believed_fits = [stages[0].best(believed, 0)]
    shown = 0  # the first stage at which the cause is beyond the tolerance of believed numbers, and above thresholds
    for before, now in pairwise(stages):
        if believed_fits[-1].cost > _LOST:
            break
        grown = now.share / before.share
        believed_fits.append(now.best(believed, 0, before.carried(believed_fits[-1], now, grown)))
        shown = shown if believed_fits[shown].cost > CLOSE else len(believed_fits) - 1
    makers = _makers(where, any(np.ptp(t.supply) > 0.0 for t in trials))
    promising = stages[shown].screened({n: m for n, m in makers.items() if n not in truth}, believed_fits[shown])

    def followed(make: Make, count: int) -> float:
        last = stages[0].best(make, count)
        for k in range(1, len(stages)):
            grown = stages[k].share / stages[k - 1].share
            fit = stages[k].best(make, count, stages[k - 1].carried(last, stages[k], grown))
            null = believed_fits[min(k, len(believed_fits) - 1)]
            if k < len(believed_fits) and fit.cost > 0.5 * null.cost:  # every rival holds the believed model
                fit = min(
                    (fit, stages[k].best(make, count, (np.zeros(count), null.shares, list(null.starts)))),
                    key=lambda f: f.cost,
                )
            last = fit
            if last.cost > CLOSE:
                break
        return last.cost

    rivals = [Rival(name, min(believed_fits[-1].cost, followed(*makers[name]))) for name in promising]
    return believed_fits[-1].cost, tuple(sorted(rivals, key=lambda r: r.noncentrality))


def _makers(where: Where, supplied: bool) -> dict[str, tuple[Make, int]]:
    """How to make each rival that the columns can reveal, from its free values (zero: none), and their number."""
    plant, joint = where.plant, where.joint
    single = plant.joints == 1
    driven = plant.drive != "none"
    shown = {
        "joint.coulomb_friction": True,
        "joint.viscous_friction": True,
        "joint.stribeck_friction": single,
        "joint.load_dependent_friction": single and plant.upright,
        "joint.quadratic_drag": True,
        "joint.friction_asymmetry": where.believed(Number.COULOMB) > 0.0,
        "joint.axis_tilt": plant.upright,
        "joint.armature": True,
        "joint.gravity_load": plant.upright,
        "actuator.delay": driven,
        "actuator.lag": driven,
        "actuator.gain": driven,
        "actuator.bias": driven,
        "actuator.deadband": driven,
        "actuator.supply_sag": driven and supplied,
        "sensor.latency": driven,
        "sensor.lag": driven,
        "sensor.bias": plant.upright or driven,
        "sensor.scale": True,
        "sensor.clock_skew": True,
    }
    causes = {c.name: c for c in LIBRARY}
    one_sided = ("actuator.lag", "actuator.deadband", "sensor.lag")  # a delay may be negative: timing is a nuisance

    def of(name: str) -> Make:
        def make(believed: Plant, x: Values) -> Hidden:
            strength = max(x[0], 0.0) if name in one_sided else x[0]
            return causes[name].hidden(float(strength), replace(where, plant=believed, draws=np.full(4, 0.4)))

        return make

    makers: dict[str, tuple[Make, int]] = {name: (of(name), 1) for name, is_shown in shown.items() if is_shown}

    def spring(believed: Plant, x: Values) -> Hidden:
        soft = 1e-6 * where.sizes.torque / where.sizes.reach
        stiffness = x[0] * where.sizes.torque / where.sizes.reach
        stiffness = soft if abs(stiffness) < soft else stiffness
        return Hidden(joint, {Number.SPRING: stiffness, Number.SPRING_REST: x[1] * where.sizes.torque / stiffness})

    def gains(believed: Plant, x: Values) -> Hidden:
        kp, kd = (believed.number(joint, n) for n in (Number.KP, Number.KD))
        return Hidden(joint, {Number.KP: kp * (1.0 + x[0]), Number.KD: kd * (1.0 + x[1])})

    makers["joint.spring"] = (spring, 2)
    if plant.drive == "position_pd":
        makers["robot.pd_gains"] = (gains, 2)
    return makers
