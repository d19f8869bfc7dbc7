"""Tasks as partial-order graphs, judged from a state log alone: no simulator, no file, no clock.

Read `graph` (nodes and edges), `history` (the equations over a whole log), `online` (the same, frame by frame),
`evaluation` and `labels`; `predicates` has one file for each condition that a node may state.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from task.evaluation import evaluate
    from task.graph import TaskGraph, TaskNode
    from task.online import OnlineJudge
    from task.roles import bind_roles

__all__ = ["OnlineJudge", "TaskGraph", "TaskNode", "bind_roles", "evaluate"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "OnlineJudge": "task.online",
        "TaskGraph": "task.graph",
        "TaskNode": "task.graph",
        "bind_roles": "task.roles",
        "evaluate": "task.evaluation",
    },
)
