"""The command line starts without what only some commands need."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.gap.joint_recordings import SLIDING, driven_joint

HEAVY = ("pxr", "matplotlib", "pybullet", "open3d", "coacd", "scipy", "trimesh", "scenec.compile", "simgap.find_gap")


def test_help_loads_no_heavy_library():
    code = f"import sys, cli.main; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_build_line_of_the_engine_does_not_reach_the_terminal(tmp_path: Path):
    folder = driven_joint(tmp_path / "axis", SLIDING, 95.0, 20.0)
    command = [sys.executable, "-m", "cli.main", "gap", "simulate", str(folder), "--out", str(tmp_path / "replay")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "PyBullet is within" in done.stdout  # The engine was loaded.
    assert "build time" not in done.stdout + done.stderr


def test_what_else_an_import_of_the_engine_writes_passes():
    """An engine that is broken says why, and only its build line is kept back."""
    code = (
        "import os, sys, types; from importlib import abc, machinery\n"
        "class Loud(abc.MetaPathFinder, abc.Loader):\n"
        "    def find_spec(self, name, path, target=None):\n"
        "        return machinery.ModuleSpec(name, self) if name == 'pybullet' else None\n"
        "    def exec_module(self, module): os.write(2, b'pybullet build time: then\\nno display\\n')\n"
        "sys.meta_path.insert(0, Loud())\n"
        "import sim.bullet"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "no display\n"
