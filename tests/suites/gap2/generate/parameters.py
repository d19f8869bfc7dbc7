"""Names of the numbers that the equations of one joint hold, in the order of the kernel's array; SI.

The compiled kernel holds these positions, and its cache looks at `kernel.py` alone: after a change here remove the
`__pycache__` beside it.
"""

from __future__ import annotations

from enum import IntEnum


class Number(IntEnum):
    """Position of a number in a joint's row of parameters; 0 means absent unless `neutral` lists another value."""

    COULOMB = 0  # N m (N)
    VISCOUS = 1  # N m s/rad
    QUADRATIC = 2  # N m s2/rad2
    STRIBECK = 3  # N m beside Coulomb friction at standstill
    STRIBECK_RATE = 4  # rad/s
    LOAD_RADIUS = 5  # m; 1 for slides
    ASYMMETRY = 6  # N m, added for motion in the positive direction, subtracted in the other
    SPRING = 7  # N m/rad
    SPRING_REST = 8  # rad
    STOP_LOWER = 9  # rad
    STOP_UPPER = 10  # rad
    STOP_STIFFNESS = 11  # N m/rad^1.5 (Hunt and Crossley)
    STOP_LOSS = 12  # s/rad
    DETENT = 13  # N m
    DETENT_COUNT = 14  # 1/rad
    DETENT_PHASE = 15  # rad
    ROTOR = 16  # kg m2 beside the declared inertia
    GRAVITY_FACTOR = 17
    TILT = 18  # rad, of gravity about the joint's axis; the first joint's counts
    KP = 19
    KD = 20
    LIMIT = 21  # N m, declared
    GAIN = 22
    BIAS = 23  # N m
    DEADBAND = 24  # N m
    RIPPLE = 25
    RIPPLE_COUNT = 26  # 1/rad
    RIPPLE_PHASE = 27  # rad
    SAG = 28
    LAG = 29  # s
    FILTER_RATE = 30  # rad/s of a second-order filter of commands
    FILTER_DAMPING = 31
    SATURATION = 32  # N m, hidden
    MOTOR_INERTIA = 33  # kg m2 behind the gear
    GEAR_STIFFNESS = 34  # N m/rad
    GEAR_LOSS = 35  # N m s/rad
    GEAR_PLAY = 36  # rad
    HYSTERESIS = 37  # N m (Bouc-Wen)
    HYSTERESIS_TRAVEL = 38  # rad
    MAGNET = 39  # N m at its steepest
    MAGNET_AT = 40  # rad
    MAGNET_WIDTH = 41  # rad
    SHAKE = 42  # N m
    SHAKE_RATE = 43  # rad/s
    HEATING = 44  # 1/rad: share by which dry friction grows with travel
    PLACE_FRICTION = 45  # share by which dry friction varies with position
    PLACE_COUNT = 46  # 1/rad
    GAIN_FADE = 47  # share of kp and kd that high speed takes away
    GAIN_FADE_RATE = 48  # rad/s
    SENSOR_LAG = 49  # s
    SENSOR_RATE = 50  # rad/s of a second-order filter of readings
    SENSOR_DAMPING = 51
    MASS = 52  # kg
    LEVER = 53  # m, of the mass centre; 0 for slides


NEUTRAL = {Number.GAIN: 1.0, Number.GRAVITY_FACTOR: 1.0, Number.STOP_LOWER: -1e9, Number.STOP_UPPER: 1e9}
