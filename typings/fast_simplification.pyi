# The part of fast-simplification that the code calls; the package ships no types.

import numpy as np
from numpy.typing import NDArray

def simplify(
    points: NDArray[np.float32], triangles: NDArray[np.int32], *, target_count: int, agg: float = 7.0
) -> tuple[NDArray[np.float32], NDArray[np.int32]]: ...
