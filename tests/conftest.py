"""Fixtures shared by all tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# A busy machine is no failure, and the same commit gives the same answer; `HYPOTHESIS_PROFILE=explore` looks elsewhere.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

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


@pytest.fixture(scope="session")
def scene_packages(bullet_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Packages for scenes: a mug, a tray and two toys, made from those meshes once for all tests."""
    out = tmp_path_factory.mktemp("scene_packages")
    meshes = ("objects/mug.obj", "tray/tray_textured.obj", "duck.obj", "domino/domino.obj")
    command = [sys.executable, "-m", "cli.main", "assets", "ingest", *(str(bullet_data / file) for file in meshes)]
    command += ["--root", str(bullet_data), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert len(list(out.glob("*/record.json"))) == len(meshes), done.stdout + done.stderr
    return out
