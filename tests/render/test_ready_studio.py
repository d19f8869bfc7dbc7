"""A fork with a ready studio draws the same bytes as a process of its own, and the parent stays at one thread."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from render.drawn_grasp import DrawnGrasp
from render.request import RenderRequest
from schemas.appearance.material import Material, TextureUse
from schemas.files import array_files
from schemas.physics import CollisionShape
from tests.support import package_samples as samples

FORKED = """
import os, sys
from pathlib import Path
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from render.ready_studio import prepare_studio
from render.request import RenderRequest
from render.views import render_all
from schemas.files import array_files
prepare_studio()
print(len(os.listdir("/proc/self/task")), flush=True)
for file in sys.argv[1:]:
    if (pid := os.fork()) == 0:
        render_all(array_files.load(RenderRequest, Path(file)))
        os._exit(0)
    assert os.waitpid(pid, 0)[1] == 0
"""


def pictures(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.glob("*.png")}


def requests(place: Path) -> list[RenderRequest]:
    """Glass and a textured box with a collider and a part; the same with a grasp."""
    box = samples.box_mesh()
    textured = replace(box, uvs=(samples.uvs(box),), material=0)
    glass = replace(samples.box_mesh(shift=(0.2, 0.0, 0.0)), material=1)
    materials = (Material("paint", base_color_texture=TextureUse("red")), Material("glass", transmission=0.8))
    model = samples.model([textured, glass], materials, [samples.Texture("red", samples.png(), "png", 4, 4)])
    shape = CollisionShape("sphere", (0.05,), samples.at(0.05))
    part_of = np.repeat([0, -1], len(box.triangles))
    whole = RenderRequest(model, (shape,), str(place / "whole"), 64, parts=("body",), part_of=part_of)
    lines_m = np.array([[[0.0, 0.0, 0.0], [0.1, 0.0, 0.1]]])
    grasp = DrawnGrasp(lines_m, "held")
    return [whole, replace(whole, out_dir=str(place / "grasp"), grasps=(grasp,), parts=(), shapes=())]


def test_forks_draw_the_same_bytes(tmp_path: Path) -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    files: dict[str, list[str]] = {}
    for way in ("cold", "warm"):
        (tmp_path / way).mkdir()
        files[way] = [str(tmp_path / way / f"{i}.npz") for i in range(2)]
        for request, file in zip(requests(tmp_path / way), files[way], strict=True):
            array_files.save(request, RenderRequest, Path(file))
    for file in files["cold"]:
        subprocess.run([sys.executable, "-m", "render", "previews", file], check=True, env=environment)
    command = [sys.executable, "-c", FORKED, *files["warm"]]
    done = subprocess.run(command, check=True, env=environment, stdout=subprocess.PIPE, text=True)
    assert done.stdout.split() == ["1"]
    for name, count in (("whole", 7), ("grasp", 1)):
        assert len(pictures(tmp_path / "warm" / name)) == count
        assert pictures(tmp_path / "warm" / name) == pictures(tmp_path / "cold" / name)
