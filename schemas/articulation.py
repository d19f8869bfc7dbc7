"""How the joints of an articulated object are used: what they open, turn or press, where a hand takes hold, and the
space that their motion needs.

Everything is given at the rest state in the asset frame; positions in m or rad, as the joint counts them
(`schemas.mechanism`).
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.anchors import AnchorPolygon, Point3
from schemas.evidence import Evidence

JointTask = Literal["open", "turn", "press"]
ContactKind = Literal["handle", "knob", "button", "edge"]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class JointContact(_Model):
    """Where a hand or finger moves the joint.

    `kind`: a handle, knob or button of the moved link, or the `edge` of the link that is farthest from the axis where
    there is none. `position_m` is the middle of the region, `normal` the unit vector out of the surface there,
    `low_m`, `high_m` its bounding box; `part` the id of the part, if one carries it. `pull` is the unit direction in
    which the region moves first when the joint leaves `closed` for `open`.
    """

    kind: ContactKind
    link: str
    part: str | None = None
    position_m: Point3
    normal: Point3
    low_m: Point3
    high_m: Point3
    pull: Point3


class SweptPrism(_Model):
    """An upright prism: a polygon in x and y of the asset frame, times the heights `low_m` to `high_m`."""

    polygon: AnchorPolygon
    low_m: float
    high_m: float


class SweptVolume(_Model):
    """What the moved links occupy at any position within the limits, the other joints at rest: the union of prisms.

    It covers the motion: every point of a moved collision shape, at every position, lies inside. `volume_m3` is the
    volume of the union, at most the volume of the prisms.
    """

    prisms: tuple[SweptPrism, ...]
    volume_m3: float


class JointUse(_Model):
    """One joint as a task sees it. Joints that follow others (couplings) and that close loops have none.

    `group` is an interaction group of the taxonomy, `unknown` with confidence 0 where nothing shows it. `closed` and
    `open` are the positions of the two ends of its use: shut and fully open, released and pressed; for a joint
    without limits rest and one turn. So opening is the sign of `open - closed`. `contact` is where it is moved.
    """

    joint: str
    group: Evidence[str]
    task: JointTask
    closed: Evidence[float]
    open: Evidence[float]
    contact: Evidence[JointContact] | None = None
    swept: SweptVolume | None = Field(default=None, description="absent where the moved links have no collision shape")

    @property
    def sense(self) -> int:
        """+1 where positions grow as it opens, turns on or is pressed, else -1."""
        return 1 if self.open.value >= self.closed.value else -1
