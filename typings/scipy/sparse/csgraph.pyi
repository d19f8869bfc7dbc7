# The part of scipy.sparse.csgraph that the code calls; SciPy ships no types for it.

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

def connected_components(
    csgraph: coo_array | csr_array, directed: bool = True, connection: Literal["weak", "strong"] = "weak"
) -> tuple[int, NDArray[np.int32]]: ...
def dijkstra(
    csgraph: csr_array, directed: bool, indices: int, *, return_predecessors: Literal[True]
) -> tuple[NDArray[np.float64], NDArray[np.int32]]: ...
def breadth_first_order(
    csgraph: csr_array, i_start: int, directed: bool = True
) -> tuple[NDArray[np.int32], NDArray[np.int32]]: ...
