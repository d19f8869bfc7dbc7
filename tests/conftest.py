"""Fixtures shared by all tests."""

from __future__ import annotations

from pathlib import Path

import pytest

SHARED = Path(__file__).parents[1].parent / "shared" / "data"


@pytest.fixture(scope="session")
def shared_assets() -> Path:
    """The shared asset folder beside the repository."""
    folder = SHARED / "assets"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside the repository")
    return folder


@pytest.fixture(scope="session")
def shared_measured() -> Path:
    """The shared folder of public recordings beside the repository."""
    folder = SHARED / "measured"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside the repository")
    return folder


@pytest.fixture(scope="session")
def bullet_data() -> Path:
    """Meshes that the installed PyBullet brings."""
    import pybullet_data

    return Path(pybullet_data.getDataPath())
