# The part of scipy.linalg that the code calls; SciPy ships no types for it.

import numpy as np
from numpy.typing import ArrayLike, NDArray

def polar(a: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def solve_banded(l_and_u: tuple[int, int], ab: ArrayLike, b: ArrayLike) -> NDArray[np.float64]: ...
