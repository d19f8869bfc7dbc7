"""What both kernels take: windows, drive and friction as arrays, and the laws of effects as addresses of functions.

Laws have one signature, so that a new effect needs no change here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numba
from numba.extending import intrinsic, overload  # Numba has no stubs

from schemas.arrays import FloatArray, IntArray
from sim.dynamics import elementwise
from sim.dynamics.hooks import JointState, StepLaw

MOST_VALUES, MOST_MEMORY = 8, 64  # parameters and remembered numbers of a law
LARGEST_RATE = 1e4  # as in `mechanism`
NO_DRIVE, EFFORT_DRIVE, PD_DRIVE = 0, 1, 2
EFFORT_LAW, TORQUE_LAW, FRICTION_LAW = 1, 2, 3

_STATE = numba.types.NamedUniTuple(numba.float64, len(JointState._fields), JointState)
_LAW = numba.float64(_STATE, numba.float64[::1], numba.float64[::1])


class Inputs(NamedTuple):
    """Worlds w, stamps k, joints j, laws l.

    t_s, q0, qd0          (w, k), (w, j), (w, j): stamps and starts.
    steps, typical_s      (k - 1,): steps in each interval between stamps, and its typical length.
    inputs                (w, k, j): commands or efforts, held from stamp to stamp; empty without a drive.
    drive                 one of the drives above, with gains kp, kd (j,), effort per unit and largest effort.
    volts                 (w, k): logged supply voltage; NaN without a log of it.
    dry, damping          (j,): dry friction and viscous damping.
    laws                  addresses (l,), with kind and joint (l,), values (l, MOST_VALUES) and memory before the
                          first step (l, MOST_MEMORY).
    by_load, has_friction whether some law needs bearing loads; whether anything rubs.
    """

    t_s: FloatArray
    steps: IntArray
    typical_s: FloatArray
    q0: FloatArray
    qd0: FloatArray
    inputs: FloatArray
    drive: int
    kp: FloatArray
    kd: FloatArray
    per_unit: float
    limit: float
    volts: FloatArray
    dry: FloatArray
    damping: FloatArray
    laws: IntArray
    kinds: IntArray
    places: IntArray
    values: FloatArray
    memory: FloatArray
    by_load: bool
    has_friction: bool


def jit(function: Callable[..., Any]) -> Any:
    """A kernel, compiled when it is first called."""
    return numba.njit(cache=True, error_model="numpy")(function)


@overload(elementwise.where)
def _where(condition: Any, one: Any, other: Any) -> Callable[..., Any]:
    def choose(condition: Any, one: Any, other: Any) -> Any:
        return one if condition else other

    return choose


@cache
def _compiled(law: StepLaw) -> Any:
    return numba.njit(_LAW, cache=True, error_model="numpy")(law)


@cache
def address_of(law: StepLaw) -> int:
    """Where a law of a step lies, compiled for one signature; `call_law` calls what lies there."""
    result = _compiled(law).get_compile_result(_LAW)
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


@intrinsic
def _call_law(typing: Any, address: Any, state: Any, values: Any, memory: Any) -> Any:

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        place, *arguments = given
        kind = context.call_conv.get_function_type(_LAW.return_type, _LAW.args)
        function = builder.inttoptr(place, kind.as_pointer())
        _, result = context.call_conv.call_function(builder, function, _LAW.return_type, _LAW.args, arguments)
        return result

    return _LAW.return_type(address, *_LAW.args), generate


# Inside a kernel, `call_law(address, state, values, memory)`. Numba's own function arguments cost 0.2 ms each and call.
call_law: Any = _call_law
