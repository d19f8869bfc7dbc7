"""Replay augmentation: recorded episodes with new static context outside the proven swept volume of all that moves."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from replay.recording.read import read_episodes
    from replay.run import Augmented, augment
    from replay.verification.check_output import check_output

__all__ = ["Augmented", "augment", "check_output", "read_episodes"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Augmented": "replay.run",
        "augment": "replay.run",
        "check_output": "replay.verification.check_output",
        "read_episodes": "replay.recording.read",
    },
)
