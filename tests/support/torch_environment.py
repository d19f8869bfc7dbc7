"""The environment that `make test` makes for PyTorch and LeRobot's library (`tools/torch-environment.sh`)."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[2] / ".venv-torch"
PYTHON = FOLDER / "bin" / "python"


def made() -> Path:
    """Its Python; an error that says what to do where nobody made it."""
    assert PYTHON.exists(), f"{FOLDER.name} is not here: `make {FOLDER.name}/.installed` brings it"
    return PYTHON
