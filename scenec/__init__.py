"""Scene compiler: turns a scene program (YAML) into a complete, checked scene, a proof that there is none, or a report
of an exhausted step budget. `compile.compile_program` runs all phases in order; `session.Session` does so edit after
edit.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from scenec.compile import Compiled, compile_program
    from scenec.session import Session

__all__ = ["Compiled", "Session", "compile_program"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Compiled": "scenec.compile",
        "Session": "scenec.session",
        "compile_program": "scenec.compile",
    },
)
