# The part of scipy.sparse.linalg that the code calls; SciPy ships no types for it.

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

def spsolve(A: csr_array, b: NDArray[np.float64]) -> NDArray[np.float64]: ...
