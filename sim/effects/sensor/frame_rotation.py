"""Frame rotation: the sensor is mounted at an angle (rad) to the body."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import TossCandidacy
from sim.effects.common.series import with_columns
from sim.effects.effect import Confusable, Effect, Parameter


def _turned(series: Series, R_BS: Rotation) -> Series:
    def orientation(quat_wxyz: FloatArray) -> FloatArray:
        turned = Rotation.from_quat(np.roll(quat_wxyz, -1, axis=1)) * R_BS
        return np.roll(turned.as_quat(), 1, axis=1)

    series = with_columns(series, ("quat_wxyz",), orientation)
    return with_columns(series, ("w_B",), R_BS.inv().apply)


def _mounting(params: Params) -> Rotation:
    return Rotation.from_rotvec([params["x_rad"], params["y_rad"], params["z_rad"]])


def _report(series: Series, params: Params, where: Place) -> Series:
    return _turned(series, _mounting(params))


def _recover(series: Series, params: Params, where: Place) -> Series:
    return _turned(series, _mounting(params).inv())


EFFECT = Effect(
    name="sensor.frame_rotation",
    kinds=("free_body", "tracking"),
    formula="reported orientation = true orientation * rotation by (x_rad, y_rad, z_rad)",
    source="tag or camera mounting",
    reveals="the body rests on its face at an angle; impacts come at wrong corners",
    parameters=(
        Parameter("x_rad", "rad", -0.6, 0.6, 0.0),
        Parameter("y_rad", "rad", -0.6, 0.6, 0.0),
        Parameter("z_rad", "rad", -0.6, 0.6, 0.0),
    ),
    confusables=(
        Confusable("body.com_offset", "rest on every face: the mounting shows as a tilt of the resting pose"),
        Confusable("world.gravity_tilt", "rest on several faces: the tilt turns with the body or stays in the world"),
    ),
    hook=SensorMap(_report, _recover),
    # The frame of which link? A single body answers that, a linkage does not.
    free_body=TossCandidacy(observable=lambda r: not r.linked, direct=("tilt_at_rest",)),
)
