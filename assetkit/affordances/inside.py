"""Where things are in relation to a containment volume: inside, above its rim, or outside; asset frame, metres."""

from __future__ import annotations

import numpy as np
import shapely

from assetkit.affordances.anchors import shape_of
from schemas.anchors import ContainmentVolume
from schemas.arrays import BoolArray, FloatArray


class Inside:
    """The free space of a volume, layer by layer from its floor up; `opening` is what the opening shares with the
    uppermost layer, where things get in.
    """

    def __init__(self, volume: ContainmentVolume) -> None:
        self.volume = volume
        x, y, self._floor_m = volume.position_m
        self._rim_m = self._floor_m + volume.height_m
        self._layers = [shapely.union_all([shape_of(p, x, y) for p in cut.polygons]) for cut in volume.slices]
        opening = shape_of(volume.opening, x, y)
        shared = [part for part in shapely.get_parts(opening & self._layers[-1]) if part.area > 0.0]
        self.opening = max(shared, key=shapely.area) if shared else opening

    def contains(self, centres_m: FloatArray, off_m: float) -> BoolArray:
        """(k,) whether points (k, 3) are below the rim and, to within `off_m`, over the floor and between the walls."""
        z = centres_m[:, 2]
        within = (z >= self._floor_m - off_m) & (z <= self._rim_m)
        layer = (z - self._floor_m) / self.volume.height_m * len(self._layers)
        layer = np.clip(np.nan_to_num(layer), 0, len(self._layers) - 1).astype(int)
        for number in np.unique(layer[within]):
            there = within & (layer == number)
            wide = self._layers[number].buffer(off_m)
            within[there] = shapely.contains_xy(wide, centres_m[there, 0], centres_m[there, 1])
        return within

    def left_through_wall(self, centres_m: FloatArray, off_m: float) -> BoolArray:
        """(n,) whether paths (k, n, 3), a row a step, end outside after they left the inside other than over the rim.

        What a fast thing sinks in before it is pushed back does not count.
        """
        flat = centres_m.reshape(-1, 3)
        above = (flat[:, 2] > self._rim_m - off_m).reshape(centres_m.shape[:2])
        inside = self.contains(flat, off_m).reshape(centres_m.shape[:2]) & ~above
        outside = ~inside & ~above
        return (inside[:-1] & outside[1:]).any(axis=0) & outside[-1]

    def resting_height(self, place_m: tuple[float, float], radius_m: float) -> float:
        """The least height of the centre of a ball at a place (x, y) that is clear of walls and floor there."""
        point = shapely.Point(place_m)
        step = self.volume.height_m / len(self._layers)
        low, clear = self._rim_m, self._rim_m
        for number in reversed(range(len(self._layers))):
            if not self._layers[number].contains(point):
                break
            low = self._floor_m + number * step
            if self._layers[number].buffer(-radius_m).contains(point):
                clear = low
        return max(clear, low + 1.1 * radius_m)
