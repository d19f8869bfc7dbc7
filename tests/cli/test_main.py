"""The command line starts without what only some commands need."""

from __future__ import annotations

import subprocess
import sys

HEAVY = ("pxr", "matplotlib", "pybullet", "open3d", "coacd", "scipy", "trimesh", "scenec.compile", "simgap.find_gap")


def test_help_loads_no_heavy_library():
    code = f"import sys, cli.main; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
