"""Arrays of floats, by a name of the generator's own: it imports nothing of what it judges."""

from __future__ import annotations

import numpy as np

Array = np.ndarray
