"""What a simulation gets wrong against measured data, and why."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from simgap.recording.read import Measurement, read
    from simgap.run import find

__all__ = ["Measurement", "find", "read"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Measurement": "simgap.recording.read",
        "find": "simgap.run",
        "read": "simgap.recording.read",
    },
)
