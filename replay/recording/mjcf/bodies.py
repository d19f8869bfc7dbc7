"""The bodies of a recorded MuJoCo model by number, as its states count them."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from formats.tree import joints_of
from replay.recording.recorded_numbers import invalid_recording
from replay.recording.robot_files import as_recording_finding
from schemas.diagnostics import InvalidInput
from schemas.robot_description import DescribedJoint, RobotDescription


class RecordedBodies:
    """Bodies depth first, the world with number 0; `joints[n]` are those that the states have, in their order.

    parent[n] is -1 for the world, X_PB[n] (4, 4) the pose in the parent with all joints at their references,
    first_geom[n] the number of the body's first geom among those of the model, body by body.
    """

    def __init__(self, description: RobotDescription) -> None:
        """Raises InvalidInput for what moves or makes bodies and is not read."""
        self.description, self.links = description, description.links
        self.file = description.source.file
        _refuse_unread(description)
        number = {link.name: k for k, link in enumerate(self.links)}
        joints_by_child = joints_of(description.joints)
        carriers = [joints_by_child.get(link.name, []) for link in self.links]
        self.parent = [number[joints[0].parent] if joints else -1 for joints in carriers]
        self.X_PB = [joints[0].X_PC if joints else np.eye(4) for joints in carriers]
        self.joints = [[joint for joint in joints if joint.moves] for joints in carriers]
        self.first_geom = [0, *accumulate(len(link.shapes) for link in self.links)]


def is_free(joint: DescribedJoint) -> bool:
    """Whether the joint lets its body float (MuJoCo: free)."""
    return joint.kind == "floating"


def _refuse_unread(description: RobotDescription) -> None:
    for element in description.unread:
        if element.changes_bodies:
            message = f"<{element.tag}> is not read; save the model from MuJoCo in full (mj_saveLastXML)"
            raise invalid_recording("replay/unsupported-model", message, element.source.file, element.source.line)
    for joint in description.joints:
        if joint.kind == "ball":
            message = f"joint '{joint.name}' is of type 'ball': only hinge, slide and free are read"
            raise invalid_recording("replay/unsupported-model", message, joint.source.file, joint.source.line)
    for link in description.links:
        for shape in link.shapes:
            if shape.problem is not None and shape.collides:
                raise InvalidInput(as_recording_finding(shape.problem))
        if link.mocap and any(shape.collides for shape in link.shapes):
            message = f"body '{link.name}' is moved from outside (mocap); its motion is not in the states"
            raise invalid_recording("replay/unsupported-model", message, link.source.file, link.source.line)
