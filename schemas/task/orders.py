"""Orders of things to make, lowered from a pipeline; they alone cross from `dsl` to the factories.

Every order has a name and plain values, so that it can be hashed, compared and stored.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

SCHEMA_VERSION = "1.0"
Mode = Literal["gendata", "benchmark"]


class Order(BaseModel):
    """A request to make one named thing."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    name: str

    @property
    def digest(self) -> str:
        """SHA-256 of its canonical JSON: the same for the same order, whatever file it stands in."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


class SceneOrder(Order):
    """A scene: its program with includes and overlays resolved, as `scenec` reads it."""

    kind: Literal["scene"] = "scene"
    program: dict[str, Any]


class RobotOrder(Order):
    """An embodiment: the fragment's values; `gripper_variant` names one of its grippers."""

    kind: Literal["robot"] = "robot"
    gripper_variant: str | None = None
    fragment: dict[str, Any] = {}


class TaskNodeOrder(BaseModel):
    """A stage of a task: conditions as written, points of ten as numerator and denominator."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    id: str
    waits_for: tuple[str, ...]
    success: dict[str, Any]
    failure: dict[str, Any] | None = None
    timeout_s: float | None = None
    points: tuple[int, int]
    true_at_reset: bool = False
    must_last: bool = False
    instruction: str = ""


class TaskOrder(Order):
    """A task with its stages in their order."""

    kind: Literal["task"] = "task"
    instruction: str = ""
    time_limit_s: float | None = None
    failure: dict[str, Any] | None = None
    roles: dict[str, tuple[str, ...]] = {}
    nodes: tuple[TaskNodeOrder, ...]


class AssemblyOrder(Order):
    """An environment of a scene, a robot and a task; `bindings` are the objects that play each role."""

    kind: Literal["assembly"] = "assembly"
    scene: str
    robot: str
    task: str
    bindings: dict[str, tuple[str, ...]] = {}


class RolloutOrder(Order):
    """Episodes in an environment, driven by one teacher, for data or for a benchmark."""

    kind: Literal["rollout"] = "rollout"
    env_ref: str
    modes: tuple[Mode, ...]
    teacher: str
    settings: dict[str, Any] = {}


class Orders(BaseModel):
    """All orders of a pipeline, in the order in which they are fulfilled; `factories` name the makers of the parts."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    schema_version: str = SCHEMA_VERSION
    factories: dict[str, str] = {}
    scenes: tuple[SceneOrder, ...] = ()
    robots: tuple[RobotOrder, ...] = ()
    tasks: tuple[TaskOrder, ...] = ()
    assemblies: tuple[AssemblyOrder, ...] = ()
    rollouts: tuple[RolloutOrder, ...] = ()

    def all(self) -> tuple[Order, ...]:
        """Every order."""
        return (*self.scenes, *self.robots, *self.tasks, *self.assemblies, *self.rollouts)
