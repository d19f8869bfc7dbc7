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

# Files that take longest, in seconds of CPU: a minute of tests that starts last would leave the other workers idle.
LONGEST = (
    "suites/gap/test_mechanism.py",  # 170
    "acceptance/test_pipeline.py",  # 160
    "acceptance/test_gap.py",  # 100
    "suites/second_engine/test_second_engine.py",  # 100
    "acceptance/test_scene_examples.py",  # 100
    "assetkit/batch/test_decisions.py",  # 50
    "laws/test_plan_cases.py",  # 50
    "acceptance/test_annotator_batch.py",
    "schemas/test_codes.py",
    "acceptance/test_replay_recordings.py",
    "assetkit/test_batch.py",
    "suites/gap/test_free_body.py",
    "assetkit/mass/test_estimate.py",
    "laws/test_collision_robustness.py",
    "sim/bullet/test_mechanism.py",
    "acceptance/test_warm_ingest.py",
    "acceptance/test_segmenter.py",
    "assetkit/parts/test_decided.py",
    "acceptance/test_scene.py",
)

SHARED = Path(__file__).parents[1].parent / "shared" / "data"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files of `LONGEST` come first, the others as found; what needs the shared data folder is skipped without it."""
    if not SHARED.is_dir():
        for item in items:
            if item.get_closest_marker("shared"):
                item.add_marker(pytest.mark.skip(reason="the shared data folder is not beside the repository"))
    rank = {Path(__file__).parent / name: k for k, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path, len(rank)))


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
