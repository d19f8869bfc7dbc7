"""Load engines by name: `"module:attribute"` gives the class or factory of that name.

Packages below `cli` import no engine. Their callers name one, and the name crosses process borders as text.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


def load_engine(name: str) -> Callable[..., Any]:
    """The factory that `name` (such as `"sim.bullet.simulator:BulletSimulator"`) refers to; imports its module.

    Raises ValueError when the name is not of that form, ImportError or AttributeError when nothing has that name.
    """
    module, colon, attribute = name.partition(":")
    if not (module and colon and attribute):
        raise ValueError(f"an engine is named 'module:attribute', such as 'package.engine:Simulator'; this is '{name}'")
    return getattr(import_module(module), attribute)
