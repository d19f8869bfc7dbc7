"""Warnings of MuJoCo go to the log of the test, not to a file MUJOCO_LOG.TXT in the working folder.

MuJoCo appends to that file unless a handler takes its warnings. A plugin of pytest, for MuJoCo in the process of the
tests; `tests.support.peers.answer_of` runs it elsewhere.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator

import pytest


@pytest.fixture(scope="session", autouse=True)
def mujoco_warnings() -> Iterator[None]:
    """Takes MuJoCo's warnings wherever a collected test imports it; without it MuJoCo stays unloaded."""
    mujoco = sys.modules.get("mujoco")
    if mujoco is None:
        yield
        return
    mujoco.set_mju_user_warning(logging.getLogger("mujoco").warning)
    yield
    mujoco.set_mju_user_warning(None)
