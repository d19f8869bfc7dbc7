"""Sim gap: names the effects that a declared model lacks, from recordings, with strengths, intervals and gains.

Read `find_gap.py` first (the pipeline), then `problem.py` (what a kind of measurement provides).
"""

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
