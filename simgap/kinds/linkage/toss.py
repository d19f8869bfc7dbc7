"""A recorded toss of a linkage with contact geometry: the whole system's flights and slides, motion of each link."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.linkage_rollout import link_body, link_poses
from simgap.kinds.free_body.toss import Impact, Slide, Toss, corners
from simgap.kinds.linkage.apply_model import AppliedLinkage

_TOUCHING = 0.01  # share of the size: a corner this close to the lowest one carries too
_JOLT = 0.05  # share of sqrt(g * size): a change of speed within a few rows that no fall makes
_CARRIED = 0.4  # share of the weight that something else than gravity carries
_JOLT_SIDE = (0.2, 4)  # of the fall time, and the fewest rows: to either side of a jolt
_ALONG = 0.9  # cosine between the slips of the corners that carry


class LinkageToss(Toss):
    """`com` (n, 3) is the mass centre of the whole.

    rotations, frames, centres   per link, the base first: (n, 3, 3), origin (n, 3) and mass centre (n, 3).
    """

    def __init__(self, applied: AppliedLinkage, series: Series) -> None:
        super().__init__(applied, series)
        model = applied.linkage
        self.linkage = model
        self.bodies = [link_body(model, name) for name in model.names]
        self.rotations, self.frames, self.centres, places = [], [], [], []
        for body, (R_BL, p_BL) in zip(self.bodies, link_poses(model, series.columns["q"]), strict=True):
            R = self.matrices @ R_BL
            at = self.origin + np.einsum("nab,nb->na", self.matrices, p_BL)
            self.rotations.append(R)
            self.frames.append(at)
            self.centres.append(at + R @ body.com_B)
            if body.shapes:
                places.append(at[:, None] + np.einsum("nij,mj->nmi", R, corners(body.shapes)))
        masses = np.array([body.mass_kg for body in self.bodies])
        self.com = np.einsum("l,lni->ni", masses / masses.sum(), np.array(self.centres))
        self.places = np.concatenate(places, axis=1)  # of every corner of every link

    @cached_property
    def flights(self) -> list[slice]:
        """Stretches in which nothing touches, as far as shapes show, and the whole falls without a jolt.

        Hinges have pins and screws that no declared shape shows: their contacts are seen in the motion alone.
        """
        weight = float(np.linalg.norm(self.gravity))
        jolt = _JOLT * float(np.sqrt(weight * self.size))
        stretches = []
        for flight in super().flights:
            cuts = [flight.start, *self._jolts(flight, jolt), flight.stop]
            for part in (slice(a, b) for a, b in pairwise(cuts) if b - a >= self.flight_rows):
                t = self.t_s[part] - self.t_s[part].mean()
                fall = 2.0 * np.polynomial.polynomial.polyfit(t, self.com[part], 2)[2]
                stretches += [part] if np.linalg.norm(fall - self.gravity) < _CARRIED * weight else []
        return stretches

    def _jolts(self, flight: slice, jolt: float) -> list[int]:
        """Rows at which the speed of the mass centre, from the rows on either side, changes by more than `jolt`."""
        side, jolt_rows = self.rows_of(*_JOLT_SIDE), []
        for row in range(flight.start + side, flight.stop - side):
            slopes = []
            for rows in (slice(row - side, row + 1), slice(row, row + side + 1)):
                t = self.t_s[rows] - self.t_s[row]
                fallen = self.com[rows] - 0.5 * t[:, None] ** 2 * self.gravity
                slopes.append(np.polynomial.polynomial.polyfit(t, fallen, 1)[1])
            if np.linalg.norm(slopes[1] - slopes[0]) > jolt:
                jolt_rows.append(row)
        return jolt_rows

    @cached_property
    def impacts(self) -> list[Impact]:
        """None: an impact on one link acts on the others through the joints."""
        return []

    def turning(self, rows: slice) -> list[FloatArray]:
        """Per link its turning rate (n - 2, 3) at the inner rows, from the rows on both sides."""
        span = (self.t_s[rows][2:] - self.t_s[rows][:-2])[:, None]
        out = []
        for R in self.rotations:
            between = R[rows][2:] @ R[rows][:-2].transpose(0, 2, 1)
            out.append(Rotation.from_matrix(between).as_rotvec() / span)
        return out

    def _slide(self, rows: slice) -> Slide | None:
        """A moment in which all corners that carry slip the same way."""
        t = self.t_s[rows] - self.t_s[rows].mean()
        centre, places = self.com[rows], self.places[rows]
        near = np.flatnonzero((places[:, :, 2] < places[:, :, 2].min() + _TOUCHING * self.size).all(axis=0))
        if not len(near):
            return None
        acceleration = 2.0 * np.polynomial.polynomial.polyfit(t, centre, 2)[2]
        slips = np.polynomial.polynomial.polyfit(t, places[:, near, :2].reshape(len(t), -1), 2)[1].reshape(-1, 2)
        speeds = np.linalg.norm(slips, axis=1)
        mean = slips.mean(axis=0)
        speed, weight = float(np.linalg.norm(mean)), float(np.linalg.norm(self.gravity))
        force = acceleration - self.gravity
        slow = speeds.min() < self.least_slip
        if slow or (slips @ mean < _ALONG * speeds * speed).any() or not 0.3 < force[2] / weight < 3.0:
            return None
        along = np.array([*(mean / speed), 0.0])
        middle = self.matrices[(rows.start + rows.stop) // 2]
        return Slide(-float(force @ along) / float(force[2]), middle.T @ along, speed)
