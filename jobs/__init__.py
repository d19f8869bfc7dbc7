"""Runs work in cells (child processes with limits); result cache, folder lock, scheduling. Read `cell` first."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from jobs.cache import Cache
    from jobs.cell import CellResult, Limits, run_cell
    from jobs.lock import exclusive
    from jobs.schedule import run_all
    from jobs.warm import run_module, warm_cells

__all__ = ["Cache", "CellResult", "Limits", "exclusive", "run_all", "run_cell", "run_module", "warm_cells"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Cache": "jobs.cache",
        "CellResult": "jobs.cell",
        "Limits": "jobs.cell",
        "exclusive": "jobs.lock",
        "run_all": "jobs.schedule",
        "run_cell": "jobs.cell",
        "run_module": "jobs.warm",
        "warm_cells": "jobs.warm",
    },
)
