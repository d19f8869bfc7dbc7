"""What a judge says of one episode: events, scores, labels, the first failure. Written by `mana task score --json`."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

SCHEMA_VERSION = "1.0"
Reason = Literal["node-failure", "timeout", "time-limit", "task-failure", "true-at-reset", "undone", "teleport"]
Stage = Literal["completed", "completed, undone", "active", "never reached"]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class NodeEvent(_Model):
    """A node was completed: its first frame, and the stamp of that (s)."""

    node: str
    frame: int
    t_s: float


class Failure(_Model):
    """The first failure of an episode. `nodes` are the node that failed, or all that were active at a failure of the
    whole task.
    """

    reason: Reason
    frame: int
    t_s: float
    nodes: tuple[str, ...]
    detail: str = ""


class NodeResult(_Model):
    """What became of a node. Frames are None where there is none.

    `activated` is the first frame with all predecessors done. `now` says whether the condition holds in the last
    frame, `undone` is the first frame after completion in which it does not.
    """

    node: str
    points: float
    stage: Stage
    activated: int | None
    completed: int | None
    seconds: float | None
    now: bool | None
    undone: int | None


class EpisodeResult(_Model):
    """The result of one log.

    `success` is whether in some frame all sinks were done and nothing had failed; `success_frame` the first such.
    `score` of ten at the end, `progress` a tenth of it. `labels` is for each stretch of frames (first, last) the node
    whose completion ends it; frames outside have none.
    """

    schema_version: str = SCHEMA_VERSION
    task: str
    frames: int
    seconds: float
    success: bool
    success_frame: int | None
    score: float
    progress: float
    events: tuple[NodeEvent, ...]
    failure: Failure | None
    nodes: tuple[NodeResult, ...]
    labels: tuple[tuple[int, int, str], ...]
    active_at_end: tuple[str, ...]
    notes: tuple[str, ...] = ()
