"""Type aliases of numpy arrays for annotations, one for each kind of number.

pyright checks the kind of number; docstrings and comments give the shape.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision: points, poses, distances, weights."""

Float32Array: TypeAlias = NDArray[np.float32]
"""Real numbers in single precision: corner normals, UVs and colours of a mesh."""

AnyFloatArray: TypeAlias = NDArray[np.floating[Any]]
"""Real numbers of either precision, where a function keeps the one it is given."""

IntArray: TypeAlias = NDArray[np.integer[Any]]
"""Whole numbers of any width: triangles, indices, counts."""

BoolArray: TypeAlias = NDArray[np.bool_]
"""Truth values: masks of faces, points, rows."""

ComplexArray: TypeAlias = NDArray[np.complex128]
"""Complex numbers in double precision: spectra, poles."""

ObjectArray: TypeAlias = NDArray[np.object_]
"""Python objects, such as the polygons of shapely."""
