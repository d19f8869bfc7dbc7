"""The file of a state log: what happened and what does not change, in one `.npz` (`schemas.files.array_files`)."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.task.scene_facts import SceneFacts
from schemas.task.state_log import StateLog

LOG_SUFFIX = ".statelog.npz"


@dataclass(frozen=True)
class LoggedScene:
    """A log with the facts of its scene; `name` says where it comes from."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    log: StateLog
    scene: SceneFacts
