"""The tool to compare with: obj2mjcf with its default CoACD decomposition, in an environment of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import trimesh

from benchmarks.running import Cost, run
from schemas.arrays import FloatArray

PINNED = ("obj2mjcf==0.0.25", "coacd==1.0.14", "trimesh==5.2.0", "mujoco==4.0.0", "numpy==2.4.6")


def environment(folder: Path) -> Path:
    """The interpreter of a virtual environment in `folder` that holds obj2mjcf; made on first use."""
    python = folder / "bin" / "python"
    if not (folder / "bin" / "obj2mjcf").exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *PINNED], check=True)
    return python


def convert(python: Path, obj_file: Path, cpu_limit_s: int) -> Cost:
    """Cost of `obj2mjcf --decompose --save-mjcf` on one file; its output goes to the folder `obj_file` without suffix.

    One thread, as ours: CoACD's idle threads wait busily and would be counted.
    """
    argv = [str(python.parent / "obj2mjcf"), "--obj-dir", str(obj_file.parent), "--obj-filter", f"^{obj_file.name}$"]
    argv += ["--decompose", "--save-mjcf", "--overwrite"]
    return run(argv, env={"OMP_NUM_THREADS": "1"}, cpu_limit_s=cpu_limit_s)


def hulls(obj_file: Path) -> list[FloatArray]:
    """Corner points (n, 3) of each convex part in source units; empty when there are none."""
    files = sorted(obj_file.with_suffix("").glob(f"{obj_file.stem}_collision_*.obj"))
    return [trimesh.load_mesh(f, process=False).vertices for f in files]
