import os
from pathlib import Path

import pytest

from assetkit.sources.discover import discover, slug
from assetkit.sources.source_file import refusal
from tests.suites.fuzz.outside import Watch, make_outside

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def ids(*paths: Path) -> dict[str, str]:
    return {c.file.path.name: c.asset_id for c in discover(list(paths))}


@pytest.mark.parametrize(
    ("stem", "expected"),
    [("Coffee Mug #2", "coffee_mug_2"), ("Küchen stuhl", "kuchen_stuhl"), ("3d-scan", "a_3d_scan"), ("日本", "a_")],
)
def test_slugs_are_identifiers(stem: str, expected: str):
    assert slug(stem) == expected


def test_folder_walk_lists_assets_and_leaves_their_parts_out(tmp_path: Path):
    (tmp_path / "a.obj").write_text(TRIANGLE)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "layer.usda").write_text('#usda 1.0\ndef Mesh "m" {}\n')
    (tmp_path / "sub" / "top.usda").write_text("#usda 1.0\n(subLayers = [@./layer.usda@])\n")
    (tmp_path / "notes.txt").write_text("not an asset")
    (tmp_path / "model.fbx").write_bytes(b"fbx")
    (tmp_path / ".hidden").mkdir()
    (tmp_path / ".hidden" / "b.obj").write_text(TRIANGLE)
    found = discover([tmp_path])
    assert [Path(c.given).relative_to(tmp_path).as_posix() for c in found] == ["a.obj", "model.fbx", "sub/top.usda"]


def test_files_that_name_each_other_are_all_kept(tmp_path: Path):
    (tmp_path / "a.usda").write_text("#usda 1.0\n(subLayers = [@./b.usda@])\n")
    (tmp_path / "b.usda").write_text("#usda 1.0\n(subLayers = [@./a.usda@])\n")
    assert len(discover([tmp_path])) == 2


def test_root_is_the_largest_folder_of_one_asset(tmp_path: Path):
    (tmp_path / "car" / "deep").mkdir(parents=True)
    (tmp_path / "car" / "deep" / "car.usda").write_text("#usda 1.0\n")
    (tmp_path / "mug.obj").write_text(TRIANGLE)
    roots = {c.file.path.name: c.file.root for c in discover([tmp_path])}
    assert roots == {"car.usda": tmp_path / "car", "mug.obj": tmp_path}


def test_root_of_an_explicit_file_is_its_folder_unless_a_package_or_the_user_says_otherwise(tmp_path: Path):
    folder = tmp_path / "pkg" / "meshes"
    folder.mkdir(parents=True)
    (folder / "m.obj").write_text(TRIANGLE)
    assert discover([folder / "m.obj"])[0].file.root == folder
    assert discover([folder / "m.obj"], root=tmp_path)[0].file.root == tmp_path
    (tmp_path / "pkg" / "package.xml").write_text("<package/>")
    assert discover([folder / "m.obj"])[0].file.root == tmp_path / "pkg"


def test_ids_on_a_clash_depend_on_content_not_on_order(tmp_path: Path):
    for name, text in (("x", TRIANGLE), ("y", TRIANGLE + "# other\n"), ("z", TRIANGLE)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "part.obj").write_text(text)
    files = [tmp_path / n / "part.obj" for n in "xyz"]
    forward = {c.given: c.asset_id for c in discover(files)}
    backward = {c.given: c.asset_id for c in discover(files[::-1])}
    assert forward == backward
    assert len(set(forward.values())) == 3
    assert all(i.startswith("part-") for i in forward.values())
    assert ids(files[0]) == {"part.obj": "part"}


def test_a_missing_source_raises(tmp_path: Path):
    with pytest.raises(FileNotFoundError):
        discover([tmp_path / "none.obj"])


def test_relative_and_absolute_sources_go_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "part.obj").write_text(TRIANGLE)
    found = discover([Path("a"), tmp_path / "b"])
    assert len({c.asset_id for c in found}) == 2


def test_odd_kinds_of_files_are_listed_but_not_opened(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.gltf")
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    (tmp_path / "gone.obj").symlink_to("nothing")
    (tmp_path / "folder.obj").mkdir()
    candidates = discover([tmp_path])
    assert [Path(c.given).name for c in candidates] == ["gone.obj", "loop.obj", "pipe.gltf"]
    refused = {Path(c.given).name: refusal(c.file) for c in candidates}
    assert {name: found.code for name, found in refused.items() if found is not None} == {
        "gone.obj": "asset/source-missing",
        "loop.obj": "asset/source-unreadable",
        "pipe.gltf": "asset/source-unreadable",
    }


def test_a_device_is_refused_before_it_is_opened(tmp_path: Path):
    (tmp_path / "zero.obj").symlink_to("/dev/zero")
    [candidate] = discover([tmp_path / "zero.obj"])
    found = refusal(candidate.file)
    assert found is not None
    assert (found.code, found.headline) == ("asset/source-unreadable", "this is a device")
    assert found.help == "give a regular file that this user may read"


def test_a_name_that_is_no_text_can_still_be_reported(tmp_path: Path):
    Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.obj")).write_text("v 0 0 0")
    [candidate] = discover([tmp_path])
    assert candidate.given.endswith("caf\\xe9.obj")
    assert candidate.given.encode()
    found = refusal(candidate.file)
    assert found is not None
    assert "UTF-8" in found.headline


def test_a_long_name_becomes_an_id_that_fits_into_file_names(tmp_path: Path):
    (tmp_path / ("x" * 240 + ".obj")).write_text("v 0 0 0")
    (tmp_path / ("x" * 239 + ".obj")).write_text("v 0 0 1")
    ids = [c.asset_id for c in discover([tmp_path])]
    assert len(set(ids)) == 2
    assert max(map(len, ids)) < 100


def test_megabytes_without_a_blank_are_scanned_once(tmp_path: Path):
    """A search that starts anew at every character would take hours."""
    (tmp_path / "layer.usda").write_text('#usda 1.0\ndef Mesh "m" {}\n')
    (tmp_path / "top.gltf").write_text("A" * 2_000_000 + " ./layer.usda " + "." * 1_000_000)
    assert [c.file.path.name for c in discover([tmp_path])] == ["top.gltf"]


def test_a_link_out_of_the_walked_folder_is_not_opened_to_see_what_it_is(tmp_path: Path):
    """MJCF is told from other XML by its text, and text is searched for references: neither is done out there."""
    outside = make_outside(tmp_path / "outside")
    inside = tmp_path / "inside"
    inside.mkdir()
    for suffix in (".xml", ".urdf", ".usda", ".obj"):
        (inside / f"part{suffix}").symlink_to(outside / f"secret{suffix}")
    with Watch(outside) as watch:
        candidates = discover([inside])
        assert watch.events() == []
    assert [Path(c.given).name for c in candidates] == ["part.obj", "part.urdf", "part.usda", "part.xml"]


def test_a_file_that_is_not_read_takes_no_name_from_one_that_is(tmp_path: Path):
    (tmp_path / "mug.obj").write_text(TRIANGLE)
    (tmp_path / "mug.fbx").write_bytes(b"fbx")
    (tmp_path / "mug.step").write_bytes(b"step")
    ids = {c.file.path.name: c.asset_id for c in discover([tmp_path])}
    assert ids["mug.obj"] == "mug"
    assert len(set(ids.values())) == 3
