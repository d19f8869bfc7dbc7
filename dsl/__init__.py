"""Task files: YAML fragments become typed documents, with every error at its file, line and column.

Read `task_file` for the task, `predicate_reader` for its conditions. Nothing here imports a simulator, USD or a
renderer.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from dsl.task_file import read_task

__all__ = ["read_task"]
__getattr__, __dir__ = lazy_exports(__name__, {"read_task": "dsl.task_file"})
