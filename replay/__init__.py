"""Replay augmentation: recorded episodes with new static objects outside the proven swept volume of all moving bodies.

Start with `augmentation` (order of the steps); `run` is the call for many recordings, `verification` the
independent check.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from replay.recording.formats.read import read_episodes
    from replay.run import Augmented, augment
    from replay.verification.check_output import check_output

__all__ = ["Augmented", "augment", "check_output", "read_episodes"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Augmented": "replay.run",
        "augment": "replay.run",
        "check_output": "replay.verification.check_output",
        "read_episodes": "replay.recording.formats.read",
    },
)
