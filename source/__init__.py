"""YAML with positions: texts become trees whose values know file, line and column; files include and override others.

Start with `include.read_tree`; `parse` reads one text, `merge` lays an overlay over its base, `tree` is the result.
The scene language and the files of tasks and pipelines are built on it. Codes of its findings begin with `scene/`:
scene programs came first, and codes are never renamed.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from source.include import read_tree
    from source.tree import Spans, Tree

__all__ = ["Spans", "Tree", "read_tree"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Spans": "source.tree",
        "Tree": "source.tree",
        "read_tree": "source.include",
    },
)
