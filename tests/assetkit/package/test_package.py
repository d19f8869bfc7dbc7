"""The package value: read once per digest, never stale; an edit gives the bytes that writing anew would give."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.package import package as package_module
from assetkit.package.package import (
    AddExtension,
    AddGrasps,
    AddPreviews,
    LastPackage,
    Package,
    RewritePhysics,
    reread,
)
from assetkit.package.write_urdf import write_urdf
from schemas.package import PackageContent
from tests.support import package_samples as samples
from usdio.reread.body import reread_body, reread_shape_contacts, reread_visual
from usdio.write.package import write_package

LINES_M = (((-0.02, 0.0, 0.05), (0.02, 0.0, 0.05)), ((0.0, -0.03, 0.02), (0.1 / 3.0, 0.03, 0.02)))


def written(folder: Path, content: PackageContent | None = None) -> Package:
    content = content or samples.full_content()
    place = folder / content.asset_id
    main_file = write_package(content, place)
    write_urdf(reread_body(main_file), content, place, reread_shape_contacts(main_file))
    return Package.on_disk(place)


@pytest.fixture
def openings(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The main files that were opened to be re-read."""
    opened: list[Path] = []

    def counted(main_file: Path) -> object:
        opened.append(main_file)
        return real(main_file)

    real = package_module.reread_package
    monkeypatch.setattr(package_module, "reread_package", counted)
    monkeypatch.setattr(package_module, "_reread", {})
    return opened


def test_equal_bytes_are_read_once(tmp_path: Path, openings: list[Path]) -> None:
    package = written(tmp_path)
    first = reread(package.main_file)
    assert reread(package.main_file) is first
    shutil.copytree(package.folder, tmp_path / "copy" / package.folder.name)
    assert reread(tmp_path / "copy" / package.folder.name / "usd" / package.main_file.name) is first
    assert len(openings) == 1
    points, triangles = reread_visual(package.main_file)
    assert np.array_equal(first.visual_points, points)
    assert np.array_equal(first.visual_triangles, triangles)
    assert first.shape_contacts == reread_shape_contacts(package.main_file)
    assert first.body.mass.mass_kg == reread_body(package.main_file).mass.mass_kg


def test_what_changes_on_disk_is_never_read_stale(tmp_path: Path, openings: list[Path]) -> None:
    """Whoever changed the file, however short after: only its bytes count, not its time or size."""
    package = written(tmp_path)
    before = reread(package.main_file).body.mass.mass_kg
    text = package.main_file.read_text()
    changed = re.sub(r"(float physics:mass = )\d", r"\g<1>9", text)
    assert len(changed) == len(text)
    assert changed != text
    package.main_file.write_text(changed)
    assert reread(package.main_file).body.mass.mass_kg >= 9.0 > before
    assert len(openings) == 2
    assert not package.is_intact()
    package.main_file.write_text(text)
    assert reread(package.main_file).body.mass.mass_kg == before
    assert len(openings) == 2
    assert package.is_intact()


def test_only_a_few_contents_are_kept(tmp_path: Path, openings: list[Path]) -> None:
    content = samples.full_content()
    for number in range(6):
        changed = replace(content, mass=replace(content.mass, mass_kg=1.0 + number))
        reread(written(tmp_path / str(number), changed).main_file)
    assert len(package_module._reread) == 4
    assert len(openings) == 6


@pytest.mark.parametrize("name", samples.variants())
def test_grasps_added_later_give_the_same_bytes(name: str, tmp_path: Path) -> None:
    content = samples.variants()[name]
    later = written(tmp_path / "later", content).edited(AddGrasps(LINES_M))
    at_once = written(tmp_path / "at_once", replace(content, grasp_lines_m=LINES_M))
    assert later.hashes == at_once.hashes
    assert later.is_intact()


def test_every_edit_knows_the_files_that_it_changes(tmp_path: Path) -> None:
    package = written(tmp_path)
    body = reread(package.main_file).body
    heavier = replace(body.mass, mass_kg=2.0 * body.mass.mass_kg)
    for edit in (
        AddGrasps(LINES_M),
        AddPreviews({"parts": b"PNG"}),
        RewritePhysics(
            heavier, body.contact.model_copy(update={"dynamic_friction": 0.11}), 2.0, {"rolling_friction": 0.1}
        ),
        AddExtension(b"{}"),
    ):
        digest = package.digest
        package = package.edited(edit)
        assert package.digest != digest
        assert dict(package.hashes) == dict(Package.on_disk(package.folder).hashes)
        assert list(package.hashes) == sorted(package.hashes)
    assert reread(package.main_file).body.mass.mass_kg == pytest.approx(heavier.mass_kg)
    assert "rolling_friction" in package.urdf_file.read_text()


def test_the_last_package_counts_for_the_same_results_and_intact_files_only(tmp_path: Path) -> None:
    package, results = written(tmp_path), (object(), object())
    last = LastPackage()
    assert last.find(results, ()) is None
    last.keep(package, results, LINES_M)
    assert last.find(results, LINES_M) is package
    assert last.find(results, ()) is None
    assert last.find((results[0], object()), LINES_M) is None
    package.urdf_file.unlink()
    assert last.find(results, LINES_M) is None
