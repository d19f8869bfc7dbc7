"""Which grasps take a rim or a handle; metres, asset frame."""

from __future__ import annotations

import numpy as np

from schemas.affordances import Grasp, Region

# A grasp takes a rim or a bar when its middle is within this distance of its line, and it is about as wide.
_ON_REGION_M, _MOST_WIDTH_RATIO = 0.02, 1.5


def takes(grasp: Grasp, region: Region) -> bool:
    """Whether the pads close on the line of the region, and on about as much as it is thick."""
    line = np.array(region.outline_m)
    near = float(np.linalg.norm(line - np.mean(grasp.contacts_m, axis=0), axis=1).min()) <= _ON_REGION_M
    return near and grasp.width_m <= _MOST_WIDTH_RATIO * max(region.size_m, _ON_REGION_M)
