import os
from pathlib import Path

import pytest

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.sources.sibling_files import sibling_statements
from assetkit.sources.source_file import SourceFile
from assetkit.stages.intake import ReadSource
from tests.support.bad_inputs.assets import CUBE, obj_text


def part(folder: Path, name: str = "part.obj", scale: float = 1000.0) -> Path:
    path = folder / name
    path.write_text(obj_text(CUBE.copy().apply_scale(scale)))
    return path


URDF = '<robot><link><visual><geometry><mesh filename="package://p/{name}" scale="{scale}"/></geometry></visual></link>'


@pytest.mark.parametrize(
    ("file", "text", "expected"),
    [
        ("arm.urdf", URDF.format(name="part.obj", scale="0.001 0.001 0.001"), "1 unit = 0.001 m"),
        ("arm.urdf", '<mesh filename="part.obj"/>', "1 unit = 1 m"),
        ("arm.xml", '<mujoco><mesh name="a" file="part.obj" scale=".01 .01 .01"/></mujoco>', "1 unit = 0.01 m"),
        ("m.sdf", "<mesh><uri>model://p/part.obj</uri><scale>0.5 0.5 0.5</scale></mesh>", "1 unit = 0.5 m"),
        ("part.json", '{"name": "lid", "units": "mm"}', "mm"),
    ],
)
def test_files_beside_the_mesh_speak(tmp_path: Path, file: str, text: str, expected: str):
    source = SourceFile(part(tmp_path), tmp_path)
    (tmp_path / file).write_text(text)
    [statement] = sibling_statements(source)
    assert expected in statement
    assert file in statement
    assert source.visited == {(tmp_path / file).resolve()}


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("arm.urdf", URDF.format(name="other.obj", scale="0.001 0.001 0.001")),
        ("arm.urdf", URDF.format(name="mypart.obj", scale="0.001 0.001 0.001")),
        ("arm.urdf", URDF.format(name="part.obj", scale="1 2 3")),
        ("arm.urdf", URDF.format(name="part.obj", scale="small")),
        ("arm.urdf", URDF.format(name="part.obj", scale="0 0 0")),
        ("other.json", '{"units": "mm"}'),
        ("part.json", "\xff\xfe"),
    ],
)
def test_others_do_not(tmp_path: Path, file: str, text: str):
    source = SourceFile(part(tmp_path), tmp_path)
    (tmp_path / file).write_text(text, encoding="latin-1")
    assert sibling_statements(source) == ()


def test_nothing_above_the_root_is_read(tmp_path: Path):
    root = tmp_path / "root"
    root.mkdir()
    (tmp_path / "arm.urdf").write_text(URDF.format(name="part.obj", scale="0.001 0.001 0.001"))
    (root / "part.json").symlink_to(tmp_path / "arm.urdf")
    assert sibling_statements(SourceFile(part(root), root)) == ()


def test_odd_files_beside_the_mesh_do_no_harm(tmp_path: Path):
    source = SourceFile(part(tmp_path), tmp_path)
    (tmp_path / "part.json").symlink_to("part.json")
    (tmp_path / "part.txt").mkdir()
    os.mkfifo(tmp_path / "arm.urdf")
    assert sibling_statements(source) == ()
    assert "part.yaml" in source.missing


def test_a_robot_description_settles_the_unit(tmp_path: Path):
    file = part(tmp_path)
    (tmp_path / "arm.urdf").write_text(URDF.format(name="part.obj", scale="0.001 0.001 0.001"))
    [item] = ReadSource().run(discover([file])[0], Options()).objects
    outcome = canonicalize(item, file.name, Options())
    assert outcome.value is not None
    assert outcome.value.meters_per_unit.value == 0.001
    assert "arm.urdf" in outcome.value.meters_per_unit.inputs[0]
    assert outcome.value.section.extent_m.value == pytest.approx((0.1, 0.1, 0.1))
    assert {f.path for f in item.files} == {"part.obj", "arm.urdf"}
