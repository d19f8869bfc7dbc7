"""The `mana` command: the only place that prints, draws progress and chooses the simulator."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from cli.main import app, run

__all__ = ["app", "run"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "app": "cli.main",
        "run": "cli.main",
    },
)
