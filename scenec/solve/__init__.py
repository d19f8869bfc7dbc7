"""The solver: transactional search for a complete assignment of poses. Start with `solver.solve`."""

from scenec.solve.cache import ComponentCache
from scenec.solve.solver import DEFAULT_BUDGET, solve

__all__ = ["DEFAULT_BUDGET", "ComponentCache", "solve"]
