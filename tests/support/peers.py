"""Outside programs that judge what Mana writes, each in an environment of its own: where they are, or a skipped test.

`make peers` installs them. Tests that call one are skipped where it is absent; on a CI machine (environment variable
`CI`) its absence is a failure. Imports pytest only when called: the environments themselves import this module.
"""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).parents[2]
ENVIRONMENTS = {"mujoco-usd": ROOT / ".venv-mujoco-usd", "torch": ROOT / ".venv-torch"}


def peer_python(name: str) -> Path:
    """The Python interpreter of a peer's environment; skips the calling test, or fails it on CI, where it is absent."""
    python = ENVIRONMENTS[name] / "bin" / "python"
    if not python.exists():
        import pytest

        absent = f"the environment of {name} is not installed: `make peers` brings it"
        pytest.fail(absent) if os.environ.get("CI") else pytest.skip(absent)
    return python
