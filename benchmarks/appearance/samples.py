"""The samples that are judged: recorded files with materials, and made ones for what no recorded file has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.appearance.made_materials import MATERIALS, made_glb

# Development assets with materials that Blender reads, below the folder of assets.
RECORDED = (
    "glb/k3dc_mixer_glb/Mixer.glb",
    "glb/khr_duck_glb/Duck.glb",
    "glb/khr_texturesettings_glb/TextureSettingsTest.glb",
    "glb/khr_boxvertexcolors_glb/BoxVertexColors.glb",
    "glb/habitat_chair_glb/chair.glb",
    "glb/gt_chr_knight_glb/chr_knight.glb",
    "glb/genesis_camera_glb/camera.glb",
    "glb/tm_alphablend_glb/AlphaBlendModeTest.glb",
    "glb/tm_monkey_glb/monkey.glb",
    "glb/sapien_water_bottle_glb/water_bottle.glb",
    "gltf/as_clearcoat/ClearCoatTest.gltf",
    "gltf/drake_010_potted_meat_can_gltf/010_potted_meat_can_textured.gltf",
    "gltf/drake_plate_8in/assets/plate_8in.gltf",
    "gltf/khr_duck_specgloss/Duck.gltf",
    "gltf/ph_painted_wooden_cabinet_02/painted_wooden_cabinet_02_1k.gltf",
    "gltf/ph_painted_wooden_stool/painted_wooden_stool_1k.gltf",
    "gltf/ph_sofa_03/sofa_03_1k.gltf",
    "derived/der_factors_sheen_glb/der_factors_sheen_glb.glb",
    "derived/der_transmission_glb/der_transmission_glb.glb",
    "derived/der_vertexcolors_draco_glb/der_vertexcolors_draco_glb.glb",
)


@dataclass(frozen=True)
class Sample:
    """A source file under a short name."""

    name: str
    source: Path


def samples(place: Path, assets: Path | None, extra: tuple[Path, ...] = ()) -> Iterator[Sample]:
    """Recorded samples that `assets` holds, then `extra` files, then made ones, which are written below `place`."""
    if assets is not None:
        for file in RECORDED:
            if (assets / file).exists():
                yield Sample(Path(file).parts[1], assets / file)
    for file in extra:
        yield Sample(file.stem, file)
    for name in MATERIALS:
        source = place / name / f"{name}.glb"
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_bytes(made_glb(name))
        yield Sample(name, source)
