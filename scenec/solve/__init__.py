"""The solver: transactional search for a complete assignment of poses. Start with `solver.solve`.

The names below are loaded when they are used: relations measure placed things with modules of this folder, and the
solver uses relations.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from scenec.solve.cache import ComponentCache
    from scenec.solve.solver import DEFAULT_BUDGET, solve

__all__ = ["DEFAULT_BUDGET", "ComponentCache", "solve"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "ComponentCache": "scenec.solve.cache",
        "DEFAULT_BUDGET": "scenec.solve.solver",
        "solve": "scenec.solve.solver",
    },
)
