"""Fixtures shared by all tests."""

from __future__ import annotations

import fcntl
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

pytest_plugins = ["tests.support.seconds", "tests.support.mujoco_log"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What needs the shared data folder is skipped, with the reason, where the folder is absent."""
    if not SHARED.is_dir():
        for item in items:
            if item.get_closest_marker("shared"):
                item.add_marker(pytest.mark.skip(reason="the shared data folder is not beside the repository"))


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
    """Packages of a mug, a tray and two toys, made from those meshes once for all tests; not to be written to."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base  # that of the run, which its workers share
    out = base / "scene_packages"
    meshes = ("objects/mug.obj", "tray/tray_textured.obj", "duck.obj", "domino/domino.obj")
    with (base / "scene_packages.lock").open("a+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not out.exists():
            command = [
                sys.executable,
                "-m",
                "cli.main",
                "assets",
                "ingest",
                *(str(bullet_data / file) for file in meshes),
            ]
            command += ["--root", str(bullet_data), "--out", str(out)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode in (0, 1), done.stdout + done.stderr
    assert len(list(out.glob("*/record.json"))) == len(meshes), sorted(out.iterdir())
    return out
