# The part of scipy.spatial.distance that the code calls; SciPy ships no types for it.

import numpy as np
from numpy.typing import ArrayLike, NDArray

def cdist(XA: ArrayLike, XB: ArrayLike, metric: str = "euclidean") -> NDArray[np.float64]: ...
def pdist(X: ArrayLike, metric: str = "euclidean") -> NDArray[np.float64]: ...
