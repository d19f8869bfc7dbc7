"""All predicates by the name that programs use (`_func`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from task.predicates.combine.all_and_only import AllAndOnly
from task.predicates.combine.counted import Counted
from task.predicates.combine.dwell import Dwell
from task.predicates.combine.logic import AllOf, AnyOf, Negation
from task.predicates.combine.matches_attribute import MatchesAttribute
from task.predicates.combine.sequence import Sequence
from task.predicates.grip.held_by import HeldBy
from task.predicates.grip.released import Released
from task.predicates.joints.joint_at import JointAt
from task.predicates.joints.joint_turned import JointTurned
from task.predicates.joints.pressed import Pressed
from task.predicates.placement.aligned import Aligned
from task.predicates.placement.beside import Beside
from task.predicates.placement.clear_region import ClearRegion
from task.predicates.placement.covered import Covered
from task.predicates.placement.hung import Hung
from task.predicates.placement.inserted import Inserted
from task.predicates.placement.inside import Inside
from task.predicates.placement.near import Near
from task.predicates.placement.on import On
from task.predicates.placement.raised import Raised
from task.predicates.placement.stacked import Stacked
from task.predicates.pose.balanced import Balanced
from task.predicates.pose.base_near import BaseNear
from task.predicates.pose.home import Home
from task.predicates.pose.oriented import Oriented
from task.predicates.pose.undisturbed import Undisturbed
from task.predicates.pose.upright import Upright
from task.predicates.protocol import Predicate

FUNC = "_func"
PREDICATES: Mapping[str, type[Predicate]] = {
    kind.func: kind
    for kind in (
        *(Inside, On, Near, Beside, Aligned, Stacked, Inserted, Hung, Covered, ClearRegion, Raised),
        *(Upright, Oriented, Undisturbed, Home, BaseNear, Balanced),
        *(JointAt, JointTurned, Pressed),
        *(HeldBy, Released),
        *(AllOf, AnyOf, Negation, Counted, AllAndOnly, Sequence, Dwell, MatchesAttribute),
    )
}
ALIASES: Mapping[str, str] = {"object_near_destination": "near"}  # names of the paper's listings


def predicate_from(written: Mapping[str, Any]) -> Predicate:
    """The predicate of a mapping with `_func` and its parameters. Raises ValueError (also pydantic's) and KeyError."""
    name = written.get(FUNC)
    if not isinstance(name, str):
        raise ValueError(f"a predicate needs `{FUNC}`")
    kind = PREDICATES.get(ALIASES.get(name, name))
    if kind is None:
        raise ValueError(f"there is no predicate `{name}`")
    return kind.model_validate({key: value for key, value in written.items() if key != FUNC})
