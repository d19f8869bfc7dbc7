"""YAML with positions: texts become trees whose values know file, line and column; files include and override others.

Start with `include.load`; `parse` reads one text, `merge` lays an overlay over its base, `tree` is what comes out. The
scene language and the files of tasks and pipelines are built on it; the codes of its findings begin with `scene/`,
because scene programs came first and codes are never renamed.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from source.include import load
    from source.merge import resolve_overlays
    from source.tree import Spans, Tree

__all__ = ["Spans", "Tree", "load", "resolve_overlays"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Spans": "source.tree",
        "Tree": "source.tree",
        "load": "source.include",
        "resolve_overlays": "source.merge",
    },
)
