"""A release looks like its source to somebody else's renderer, and a damaged one does not."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Usd, UsdShade

from assetkit.library.validate import main_usd_files
from assetkit.package.record import read_record
from benchmarks.appearance import cycles
from benchmarks.appearance.flip import mean_flip
from benchmarks.appearance.judge import X_AS_of, box_frame, compare, ingested
from benchmarks.appearance.made_materials import MATERIALS, made_glb
from benchmarks.appearance.samples import samples
from benchmarks.appearance.table import MOST_MEDIAN, MOST_PER_VIEW
from schemas.asset import AssetRecord
from tests.support.gltf_files import read, signed_volume
from tests.support.peers import needs_blender

SMALL = cycles.Quality(size_px=96, samples=16)


@pytest.mark.long
def test_a_release_looks_like_its_source_and_damage_is_seen(tmp_path: Path) -> None:
    needs_blender()
    sample = next(each for each in samples(tmp_path / "sources", None) if each.name == "made_bumps")
    ((package,),) = ingested([sample], tmp_path / "library").values()
    result = compare(sample, (package,), tmp_path / "made_bumps", SMALL)
    assert max(result.cycles.values()) <= MOST_MEDIAN
    assert max(result.own.values()) <= MOST_MEDIAN
    assert result.meets
    assert Image.open(tmp_path / "made_bumps" / "sheet.png").size[0] == 4 * SMALL.size_px
    record = read_record(package)
    assert record is not None
    X_AB = cycles.from_gltf(X_AS_of(record))
    source = cycles.draw(sample.source, X_AB, box_frame(record), tmp_path / "made_bumps" / "source", SMALL)
    for damage in (_recolour, _turn_green):
        damaged = tmp_path / damage.__name__ / package.name
        shutil.copytree(package, damaged)
        damage(damaged)
        flips = mean_flip(source, _drawn(damaged, record))
        assert min(flips.values()) > MOST_MEDIAN, damage.__name__
        assert max(flips.values()) > MOST_PER_VIEW, damage.__name__


def _drawn(package: Path, record: AssetRecord) -> dict[str, cycles.Picture]:
    return cycles.draw(main_usd_files(package)[0], np.eye(4), box_frame(record), package.parent / "pictures", SMALL)


def _recolour(package: Path) -> None:
    """Red and blue of the base colour change places."""
    stage = Usd.Stage.Open(str(main_usd_files(package)[0]))
    surface = next(
        shader for prim in stage.Traverse() if (shader := UsdShade.Shader(prim)).GetShaderId() == "UsdPreviewSurface"
    )
    color = surface.GetInput("diffuseColor")
    color.Set(Gf.Vec3f(*reversed(color.Get())))
    stage.Save()


def _turn_green(package: Path) -> None:
    """Green of the normal map points down."""
    file = next(iter(package.rglob("textures/*.png")))
    pixels = np.asarray(Image.open(file).convert("RGB")).copy()
    pixels[..., 1] = 255 - pixels[..., 1]
    Image.fromarray(pixels).save(file)


@pytest.mark.parametrize("name", MATERIALS)
def test_made_samples_are_read_without_losses_and_are_the_same_each_time(name: str, tmp_path: Path) -> None:
    data = made_glb(name)
    outcome = read(tmp_path, data)
    assert outcome.value is not None
    assert outcome.diagnostics == ()
    (mesh,) = outcome.value.meshes
    assert signed_volume(mesh) == pytest.approx(4.0 / 3.0 * np.pi * 0.1**3, rel=0.01)
    assert made_glb(name) == data
