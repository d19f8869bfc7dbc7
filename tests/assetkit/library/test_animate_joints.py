"""GIFs of moving joints: there and back, the same every time; refused where nothing moves."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from assetkit.library.animate_joints import looped_gif
from assetkit.library.previews import animation
from schemas.diagnostics import Diagnostic, InvalidInput
from tests.support.bad_inputs.assets import CUBE, obj_text

DRAWER = """<robot name="drawer">
  <link name="case"><visual><geometry><box size="0.4 0.4 0.02"/></geometry></visual></link>
  <link name="tray"><visual><geometry><box size="0.3 0.3 0.1"/></geometry></visual></link>
  <joint name="slide" type="prismatic"><parent link="case"/><child link="tray"/><origin xyz="0 0 0.1"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
</robot>
"""


def refusal(path: Path, out: Path, *joints: str) -> Diagnostic:
    with pytest.raises(InvalidInput) as caught:
        animation(path, out, frames=3, joints=joints)
    return caught.value.diagnostic


def frames_of(data: bytes) -> list[np.ndarray]:
    with Image.open(io.BytesIO(data)) as gif:
        assert gif.info["loop"] == 0
        pictures = []
        for k in range(getattr(gif, "n_frames", 1)):
            gif.seek(k)
            pictures.append(np.asarray(gif.convert("RGB")).astype(int))
    return pictures


def test_a_gif_goes_there_and_back():
    shades = [Image.new("RGB", (8, 8), (60 * k, 200, 10)) for k in range(4)]
    files = [io.BytesIO() for _ in shades]
    for shade, file in zip(shades, files, strict=True):
        shade.save(file, "PNG")
    frames = frames_of(looped_gif([file.getvalue() for file in files]))
    assert [round(frame[0, 0, 0] / 60) for frame in frames] == [0, 1, 2, 3, 2, 1]


def test_a_drawer_slides_out_and_back_in_the_same_bytes(tmp_path: Path):
    source = tmp_path / "drawer.urdf"
    source.write_text(DRAWER)
    one = animation(source, tmp_path / "one.gif", frames=3).read_bytes()
    named = animation(source, tmp_path / "new" / "two.gif", frames=3, joints=["slide"]).read_bytes()
    assert one == named
    frames = frames_of(one)
    assert len(frames) == 4
    assert np.abs(frames[1] - frames[0]).max() > 50
    assert np.array_equal(frames[1], frames[3])
    unknown = refusal(source, tmp_path / "none.gif", "door")
    assert unknown.code == "asset/missing-joint"
    assert "slide" in unknown.headline
    assert not (tmp_path / "none.gif").exists()


def test_a_rigid_object_has_nothing_to_move(tmp_path: Path):
    (tmp_path / "part.obj").write_text(obj_text(CUBE))
    assert refusal(tmp_path / "part.obj", tmp_path / "part.gif").code == "asset/missing-joint"
