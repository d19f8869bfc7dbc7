"""Outside programs that judge what Mana writes, each in an environment of its own: where they are, or a skipped test.

`make peers` installs them. Tests that call one are skipped where it is absent; on a CI machine (environment variable
`CI`) its absence is a failure. Imports pytest only when called: the environments themselves import this module.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, NoReturn

ROOT = Path(__file__).parents[2]
ENVIRONMENTS = {"mujoco-usd": ROOT / ".venv-mujoco-usd", "torch": ROOT / ".venv-torch"}


def peer_python(name: str) -> Path:
    """The Python interpreter of a peer's environment; skips the calling test, or fails it on CI, where it is absent."""
    python = ENVIRONMENTS[name] / "bin" / "python"
    if not python.exists():
        _absent(name)
    return python


def needs_blender() -> None:
    """Skips the calling test, or fails it on CI, where `mana setup blender` was not run."""
    from assetkit.blender import environment

    if environment.python() is None:
        _absent("Blender")


def chromium() -> str:
    """The program Chromium; skips the calling test, or fails it on CI, where there is none."""
    program = shutil.which("chromium")
    if program is None:
        _absent("Chromium")
    return program


def _absent(name: str) -> NoReturn:
    import pytest

    absent = f"the environment of {name} is not installed: `make peers` brings it"
    pytest.fail(absent) if os.environ.get("CI") else pytest.skip(absent)


def answer_of(name: str, script: str, request: object, timeout_s: float) -> Any:
    """The JSON answer of a script that a peer's interpreter runs, with a JSON request on stdin.

    It works in a folder of its own, since MuJoCo leaves a log where it works. Raises AssertionError where it fails.
    """
    with tempfile.TemporaryDirectory() as place:
        done = subprocess.run(
            [str(peer_python(name)), "-P", script],
            input=json.dumps(request),
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
            cwd=place,
        )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)
