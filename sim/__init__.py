"""Rigid-body simulation: the simulator port, its PyBullet implementation, multibody dynamics in numpy, and effects.

Read `sim.port` first. Only `sim.bullet` imports pybullet.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from sim.fake import FakeSimulator
    from sim.named_engine import load_engine
    from sim.port import DropSettings, Simulator, World

__all__ = ["DropSettings", "FakeSimulator", "Simulator", "World", "load_engine"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "DropSettings": "sim.port",
        "FakeSimulator": "sim.fake",
        "Simulator": "sim.port",
        "World": "sim.port",
        "load_engine": "sim.named_engine",
    },
)
