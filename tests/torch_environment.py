"""The environment that `make test` makes for PyTorch and LeRobot's library (`tools/torch-environment.sh`)."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import pytest

FOLDER = Path(__file__).parents[1] / ".venv-torch"
LEFT_OUT = "left-out"


def absent(what: str, folder: Path = FOLDER) -> NoReturn:
    """Skips where making the environment said why it leaves this out; fails where nobody did."""
    note = folder / LEFT_OUT
    if note.is_file():
        pytest.skip(f"{what} is not here: {note.read_text().strip()}")
    pytest.fail(f"{what} is not here: `make {folder.name}/.installed` brings it")
