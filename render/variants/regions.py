"""The flat colours that distinguish regions in a picture, and the region at each of its pixels."""

from __future__ import annotations

from typing import Final

import numpy as np

from schemas.arrays import IntArray

MOST_REGIONS: Final = 32 * 32
OTHER: Final = -1  # a surface of no region
EMPTY: Final = -2  # no surface, or the edge between two
_STEP: Final = 8  # of 255, between the colours of neighbouring numbers
_OTHER_RGB: Final = (0, 255, 0)


def region_rgb(region: int) -> tuple[int, int, int]:
    """The colour (0..255) of a region by number, or of `OTHER`. Raises ValueError above `MOST_REGIONS`."""
    if region >= MOST_REGIONS:
        raise ValueError(f"{region} is not below {MOST_REGIONS}")
    return _OTHER_RGB if region == OTHER else (region % 32 * _STEP, region // 32 * _STEP, 255)


def regions_of(pixels: IntArray) -> IntArray:
    """(h, w) regions of a picture (h, w, 3) of such colours; mixed colours are `EMPTY`."""
    red, green, blue = (pixels[..., channel].astype(np.int64) for channel in range(3))
    region = np.where(
        (blue == 255) & (red % _STEP == 0) & (green % _STEP == 0), red // _STEP + green // _STEP * 32, EMPTY
    )
    return np.where((red == 0) & (green == 255) & (blue == 0), OTHER, region)
