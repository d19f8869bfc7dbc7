"""Affordances of an object: possible interactions with its parts, and how they are done, as relations
(part, task, interaction).

Lengths in metres, frame of the asset. A gripper frame G has its origin between the pads, +z along the approach, and x
along the closing axis, so that the fingers close from -x and +x.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, SerializeAsAny

from schemas.anchors import Point3
from schemas.evidence import Evidence

RegionKind = Literal["rim", "handle", "spout", "hang_hole", "lid", "knob", "button", "edge"]
Task = Literal["pour", "carry", "hang", "open", "turn", "press"]
Interaction = Literal["tilt", "wrap", "hook", "lift_off", "twist", "push", "pull"]
Trial = Literal["held", "not_held", "untried"]
GripperSize = Literal["small", "medium", "large"]
WHOLE = "object"  # The part that an affordance belongs to when no named part carries it.


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class OrientationRequirement(_Model):
    """While the task is done, `axis` (unit vector of the asset frame) must stay within `within_rad` of `toward`.

    `horizontal` means within that angle of the horizontal plane.
    """

    axis: Point3
    toward: Literal["up", "down", "horizontal"]
    within_rad: float


class Grasp(_Model):
    """Two parallel pads close on the object, press and lift it.

    `position_m` and `quat_wxyz` are the gripper frame G in the asset frame; `contacts_m` the two places that the pads
    touch first, along -x and +x of G; `width_m` their distance and `opening_m` the distance of the pads before.
    `angle_rad` is the larger angle between the closing axis and a surface normal, `cone_rad` the half angle of the
    friction cone; `force_n` what each pad presses with; `quality` is 0 to 1.
    `gripper` is the size of the gripper that it is for (`geom.grasp.gripper`).
    `poses` are the stable poses (indices) in which neither fingers nor hand touch the ground.
    """

    kind: Literal["grasp"] = "grasp"
    affordance_id: str
    part: str = WHOLE
    task: Literal["pick"] = "pick"
    interaction: Literal["parallel_jaw"] = "parallel_jaw"
    position_m: Point3
    quat_wxyz: tuple[float, float, float, float]
    contacts_m: tuple[Point3, Point3]
    width_m: float
    opening_m: float
    angle_rad: float
    cone_rad: float
    force_n: float
    quality: float
    poses: tuple[int, ...]
    trial: Trial = "untried"
    gripper: GripperSize = Field(default="medium", exclude_if=lambda size: size == "medium")
    slip_m: float | None = Field(
        default=None, description="how far the mass centre moved in the fingers, if it was held"
    )
    orientation: OrientationRequirement | None = None


class Region(_Model):
    """A place that serves a task: a rim to pour over, a handle to carry by, a hole to hang it up by, a button to press.

    `position_m` is its middle, `direction` the unit vector out of the object there (for a hole: through it), and
    `outline_m` points along it in order: the loop of a rim or hole, the axis of a bar, the ends of a lip.
    `size_m` is what a gripper or hook must fit: diameter of an opening or hole, thickness of a bar, edge of a button.
    `held_by` names grasps that take it. `joint` is the joint of an articulated object that it moves.
    """

    kind: RegionKind
    affordance_id: str
    part: str = WHOLE
    task: Task
    interaction: Interaction
    position_m: Point3
    direction: Point3
    outline_m: tuple[Point3, ...]
    size_m: float
    held_by: tuple[str, ...] = ()
    joint: str | None = Field(default=None, exclude_if=lambda joint: joint is None)
    orientation: OrientationRequirement | None = None


Affordance: TypeAlias = Grasp | Region
# Evidence is made without naming the type of its value; a union of evidences must take it as it is.
AffordanceEvidence: TypeAlias = SerializeAsAny[Evidence[Grasp] | Evidence[Region]]
