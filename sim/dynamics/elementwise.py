"""Elementwise choice between two values, for laws that run on arrays of worlds and compiled for one world."""

from __future__ import annotations

from typing import Any

import numpy as np


def where(condition: Any, one: Any, other: Any) -> Any:
    """`one` where the condition holds, else `other`; a plain choice between scalars once compiled."""
    return np.where(condition, one, other)
