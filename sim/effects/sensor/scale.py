"""Sensor scale: positions and their rates are reported in a wrong measure, off by a factor."""

from __future__ import annotations

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import TossCandidacy
from sim.effects.common.series import with_columns
from sim.effects.effect import Confusable, Effect, Parameter

_SCALE_FACTORS = (0.7, 1.4)
_READ = ("q", "reading", "qd", "qdd", "p", "v_W")


def _report(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, _READ, lambda true: true * params["factor"])


def _recover(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, _READ, lambda read: read / params["factor"])


EFFECT = Effect(
    name="sensor.scale",
    kinds=("mechanism", "free_body", "tracking"),
    formula="reading = factor * truth, of positions and their rates",
    source="calibration",
    reveals="free fall is not at g; contact heights are off in proportion",
    parameters=(Parameter("factor", "1", 0.5, 2.0, 1.0),),
    confusables=(
        Confusable("world.gravity_magnitude", "measure a known length: contact heights tell the scale"),
        Confusable("joint.gravity_load", "swing at small and large amplitudes"),
    ),
    hook=SensorMap(_report, _recover, spares_joints=True),  # angles are no lengths
    # A length scale shows in falls and in the height at rest: both must give the same value.
    free_body=TossCandidacy(
        bounds=lambda r: {"factor": _SCALE_FACTORS},
        direct=("length_of_falls", "height_at_rest"),
        linked_direct=("length_of_falls",),
        bounds_from_direct=True,
    ),
    plot_against="position",
)
