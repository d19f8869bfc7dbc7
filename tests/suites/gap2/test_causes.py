"""Each cause is a library effect or an outside one, shows in its scenes, and its checked parameters mean the same."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from sim.effects.library import EFFECTS, effect
from tests.suites.gap2.generate.causes.cause import Cause, Where
from tests.suites.gap2.generate.causes.combinations import PAIRS
from tests.suites.gap2.generate.causes.library import LIBRARY, library_cause
from tests.suites.gap2.generate.causes.outside import OUTSIDE
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import observe
from tests.suites.gap2.generate.power import LEVELS, miss
from tests.suites.gap2.generate.scenes import Recording, draw_plant, draw_recording, sizes_of

# Beside the world, the body and its contacts, which a mechanism's log does not show.
NOT_OF_ONE_JOINT = {"sensor.frame_rotation", "sensor.velocity_age"}
BELIEVED = {
    "joint.coulomb_friction": Number.COULOMB,
    "joint.viscous_friction": Number.VISCOUS,
    "kp": Number.KP,
    "kd": Number.KD,
}
LIMITS = ("upper_rad", "limit_Nm")  # without effect where nothing reaches them
ALL = (*LIBRARY, *OUTSIDE)
CHECKED = [c for c in LIBRARY if c.name not in ("joint.stribeck_friction", "joint.backlash")]
SHARES = [c for c in CHECKED if c.name in ("joint.gravity_load", "actuator.gain", "sensor.scale", "sensor.clock_skew")]


def name_of(cause: Cause) -> str:
    return cause.name


@cache
def placed(cause: Cause) -> tuple[Where, Recording]:
    """A mechanism that moves, of the first scene of a cause."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        plant, period = draw_plant(cause.scenes[0], rng, rubs=cause.rubs)
        recording = draw_recording(plant, period, rng, supply=cause.supply)
        sizes = sizes_of(plant, recording, 0)
        if sizes.speed > 0.0 and sizes.reach > 30.0 * recording.sigma:
            return Where(plant, 0, sizes, rng.random(4)), recording
    raise AssertionError(f"no mechanism moves in {cause.scenes[0]}")


def test_library_causes_are_the_library_effects_of_joints() -> None:
    listed = {e.name for e in EFFECTS if e.family in ("joint", "actuator", "sensor", "robot")}
    assert {c.name for c in LIBRARY} == listed - NOT_OF_ONE_JOINT
    assert all(c.name.startswith("outside.") for c in OUTSIDE)


def test_both_of_two_causes_show_in_their_scene() -> None:
    for first, second, scene in PAIRS:
        assert scene in library_cause(first).scenes
        assert scene in library_cause(second).scenes


@pytest.mark.parametrize("cause", ALL, ids=name_of)
def test_cause_at_its_most_is_visible_and_at_its_least_smaller(cause: Cause) -> None:
    where, recording = placed(cause)

    def miss_at(strength: float) -> float:
        readings = observe(where.plant, cause.hidden(strength, where), recording.trials, recording.step_s)
        return miss(where.plant, readings, recording.trials, recording.sigma, recording.horizon_s, recording.step_s)

    assert miss_at(cause.most) > max(LEVELS["medium"], miss_at(cause.least))


@pytest.mark.parametrize("cause", CHECKED, ids=name_of)
def test_checked_parameters_are_the_library_s_and_without_effect_at_no_strength(cause: Cause) -> None:
    where, _ = placed(cause)
    null, checked = effect(cause.name).null(), cause.checked(cause.hidden(0.0, where))
    assert checked
    for parameter, value in checked.items():
        believed = BELIEVED.get(cause.name, BELIEVED.get(parameter))
        if parameter in LIMITS:
            assert value >= (where.sizes.high if parameter == "upper_rad" else where.sizes.effort)
        else:
            assert value == null[parameter] + (where.believed(believed) if believed is not None else 0.0)


@pytest.mark.parametrize("cause", SHARES, ids=name_of)
def test_factor_is_off_by_the_strength(cause: Cause) -> None:
    where, _ = placed(cause)
    assert list(cause.checked(cause.hidden(0.25, where)).values()) == [1.0 + where.way * 0.25]
