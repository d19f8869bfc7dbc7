# The part of scipy.spatial that the code calls; SciPy ships no types for it.

from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

class QhullError(RuntimeError): ...

class ConvexHull:
    def __init__(self, points: ArrayLike, incremental: bool = False, qhull_options: str | None = None) -> None: ...
    points: NDArray[np.float64]
    vertices: NDArray[np.int32]
    simplices: NDArray[np.int32]
    neighbors: NDArray[np.int32]
    equations: NDArray[np.float64]
    area: float
    volume: float

class Delaunay:
    def __init__(self, points: ArrayLike, qhull_options: str | None = None) -> None: ...
    simplices: NDArray[np.int32]
    def find_simplex(self, xi: ArrayLike) -> NDArray[np.int32]: ...

class KDTree:
    def __init__(self, data: ArrayLike) -> None: ...
    def query(
        self, x: ArrayLike, k: int = 1, *, p: float = 2.0, distance_upper_bound: float = ...
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]: ...
    @overload
    def query_pairs(self, r: float, p: float = 2.0, *, output_type: Literal["ndarray"]) -> NDArray[np.intp]: ...
    @overload
    def query_pairs(self, r: float, p: float = 2.0) -> set[tuple[int, int]]: ...
    def query_ball_point(self, x: ArrayLike, r: ArrayLike, p: float = 2.0) -> NDArray[Any]: ...  # of lists of indices
