# The part of scipy.optimize that the code calls; SciPy ships no types for it.

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

class RootResults:
    root: float
    converged: bool

class _ScalarMinimum:
    x: float
    fun: float
    success: bool

class _LinearProgram:
    x: NDArray[np.float64] | None
    fun: float
    success: bool
    status: int
    message: str
    ineqlin: Any  # its `marginals` are the multipliers of the rows
    lower: Any
    upper: Any

class _LinearLeastSquares:
    x: NDArray[np.float64]
    cost: float
    success: bool

def lsq_linear(A: ArrayLike, b: ArrayLike, bounds: tuple[ArrayLike, ArrayLike]) -> _LinearLeastSquares: ...
def root_scalar(
    f: Callable[..., Any],
    args: tuple[Any, ...] = (),
    *,
    bracket: Sequence[float],
    xtol: float | None = None,
    rtol: float | None = None,
) -> RootResults: ...
def minimize_scalar(
    fun: Callable[[float], float],
    *,
    bounds: tuple[float, float],
    method: Literal["bounded"],
    options: Mapping[str, Any] | None = None,
) -> _ScalarMinimum: ...
def linprog(
    c: ArrayLike,
    A_ub: Any = None,
    b_ub: ArrayLike | None = None,
    A_eq: Any = None,
    b_eq: ArrayLike | None = None,
    *,
    bounds: Any = ...,
    method: str = "highs",
    options: Mapping[str, Any] | None = None,
) -> _LinearProgram: ...
