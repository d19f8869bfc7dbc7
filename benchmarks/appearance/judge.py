"""Packages beside their sources, drawn by Blender's Cycles and by Mana, compared by FLIP.

    python -m benchmarks.appearance.judge OUT [--assets DIR] [--only NAME ...]

Each sample is ingested as `mana assets ingest` does. Cycles draws the source, read by Blender's own glTF importer, and
the released USD, read by Blender's own USD importer, with the same cameras (the four standard views) and light
(`cycles_worker`). Mana draws the model that its reader makes of the source, and the one that it reads back. Frames are
those that the record states; nothing is aligned by pictures. FLIP (Andersson et al., 2020; its authors' library) is
averaged over the pixels that the object covers in either picture. `noise` is what two drawings of the source with other
seeds give. OUT holds a table (`table.md`), `results.json`, and a sheet per sample: source, release, difference.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import flip_evaluator
import numpy as np
from PIL import Image

from assetkit.blender import environment
from assetkit.library.preview_worker import first_model
from assetkit.package.preview_images import render_views
from assetkit.package.record import main_usd_files, read_record
from benchmarks.appearance.made_materials import APART, MATERIALS, made_glb
from benchmarks.assets.heavy_scans import read_model
from geom.pose import matrix_of
from render.camera import FIELD_OF_VIEW_RAD, STANDARD_VIEWS, annotation_frame, camera
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput

# Development samples with materials that Blender reads; below the assets folder. True: glass or a coat, judged apart.
RECORDED: dict[str, bool] = {
    "glb/k3dc_mixer_glb/Mixer.glb": False,
    "glb/khr_duck_glb/Duck.glb": False,
    "glb/khr_texturesettings_glb/TextureSettingsTest.glb": False,
    "glb/khr_boxvertexcolors_glb/BoxVertexColors.glb": False,
    "glb/habitat_chair_glb/chair.glb": False,
    "glb/gt_chr_knight_glb/chr_knight.glb": False,
    "glb/genesis_camera_glb/camera.glb": False,
    "gltf/ph_painted_wooden_cabinet_02/painted_wooden_cabinet_02_1k.gltf": False,
    "gltf/ph_painted_wooden_stool/painted_wooden_stool_1k.gltf": False,
    "gltf/ph_sofa_03/sofa_03_1k.gltf": False,
    "gltf/drake_plate_8in/assets/plate_8in.gltf": False,
    "gltf/khr_duck_specgloss/Duck.gltf": False,
    "glb/tm_alphablend_glb/AlphaBlendModeTest.glb": False,
    "glb/sapien_water_bottle_glb/water_bottle.glb": True,
    "gltf/as_clearcoat/ClearCoatTest.gltf": True,
}
SIZE_PX, SAMPLES, SEEDS = 256, 48, (1, 2)
LAMPS_AWAY = 3.0  # in largest edges of the box
BACKGROUND = 0.5  # sRGB grey behind the object, the same in all pictures
COVERED = 0.5  # alpha
MOST_PER_VIEW, MOST_MEDIAN = 0.10, 0.05
TO_NATIVE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # glTF's axes from Blender's
_LIMIT_S = 900.0
Pictures = dict[str, tuple[FloatArray, FloatArray]]  # by view: sRGB (h, w, 3) over the background, alpha (h, w)


@dataclass(frozen=True)
class Judged:
    """Mean FLIP by view: source against release by Cycles and by Mana, and source against itself with other noise."""

    name: str
    apart: bool
    cycles: dict[str, float]
    mana: dict[str, float]
    noise: dict[str, float]

    @property
    def worst(self) -> float:
        """Of the views, by Cycles."""
        return max(self.cycles.values())

    @property
    def mean(self) -> float:
        """Over the views, by Cycles."""
        return float(np.mean(list(self.cycles.values())))


def main() -> int:
    """Judges samples and writes the results; 1 where none could be judged."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--assets", type=Path, help="folder of the recorded samples; made ones need none")
    parser.add_argument("--only", nargs="*", default=[], help="names of samples, or parts of them")
    asked = parser.parse_args()
    program = environment.python()
    if program is None:
        sys.stderr.write("Blender is absent: run `mana setup blender`\n")
        return 2
    results = []
    for name, source, apart in _samples(asked.out / "sources", asked.assets):
        if asked.only and not any(part in name for part in asked.only):
            continue
        try:
            results.append(judged(program, name, source, asked.out / name, apart))
        except (ValueError, InvalidInput, subprocess.SubprocessError) as error:
            print(f"{name}: not judged: {error}", flush=True)
            continue
        print(_row(results[-1]), flush=True)
    (asked.out / "results.json").write_text(json.dumps([asdict(r) for r in results], indent=1) + "\n")
    (asked.out / "table.md").write_text(table(results))
    print(table(results))
    return 0 if results else 1


def _samples(place: Path, assets: Path | None) -> Iterator[tuple[str, Path, bool]]:
    """Name, file, whether it is judged apart."""
    if assets is not None:
        for file, apart in RECORDED.items():
            if (assets / file).exists():
                yield Path(file).parts[1], assets / file, apart
    place.mkdir(parents=True, exist_ok=True)
    for name in MATERIALS:
        made = place / name / f"{name}.glb"
        made.parent.mkdir(exist_ok=True)
        made.write_bytes(made_glb(name))
        yield name, made, name in APART


def judged(program: Path, name: str, source: Path, out: Path, apart: bool) -> Judged:
    """Ingests a sample and compares its release with it. Raises ValueError where there is no package."""
    package = ingested(source, out / "library")
    record = read_record(package)
    if record is None:
        raise ValueError("no record")
    release, X_AS = main_usd_files(package)[0], asset_from_source(record)
    X_AB = X_AS.copy()
    X_AB[:3, :3] = X_AS[:3, :3] @ TO_NATIVE
    before = drawn_by_cycles(program, source, X_AB, record, out / "source", SEEDS[0])
    again = drawn_by_cycles(program, source, X_AB, record, out / "noise", SEEDS[1])
    after = drawn_by_cycles(program, release, np.eye(4), record, out / "release", SEEDS[0])
    mine = drawn_by_mana(source, X_AS, record, out), drawn_by_mana(release, np.eye(4), record, out)
    _sheet(before, after, *mine).save(out / "sheet.png")
    return Judged(name, apart, flip(before, after), flip(*mine), flip(before, again))


def ingested(source: Path, library: Path) -> Path:
    """The package that the command line makes of a file."""
    subprocess.run(
        [sys.executable, "-m", "cli.main", "assets", "ingest", str(source), "--out", str(library)],
        check=False,
        capture_output=True,
        timeout=_LIMIT_S,
    )
    packages = sorted(path.parent for path in library.glob("*/record.json"))
    if len(packages) != 1:
        raise ValueError(f"{len(packages)} packages")
    return packages[0]


def asset_from_source(record: AssetRecord) -> FloatArray:
    """(4, 4) X_AS, with the source's unit: p_A = X_AS p_S."""
    X_AS = np.eye(4)
    scale = record.source.meters_per_unit.value
    assert scale is not None
    X_AS[:3, :3] = scale * matrix_of(np.asarray(record.geometry.source_quat_wxyz))
    X_AS[:3, 3] = record.geometry.origin_offset_m
    return X_AS


def box_of(record: AssetRecord) -> tuple[FloatArray, FloatArray]:
    """The lowest and highest corner (3,) of the asset."""
    frame, size = record.geometry.annotation_frame, np.asarray(record.geometry.extent_m.value)
    return np.asarray(frame.centre_m) - size / 2.0, np.asarray(frame.centre_m) + size / 2.0


def drawn_by_cycles(
    program: Path, file: Path, X_AB: FloatArray, record: AssetRecord, out: Path, seed: int
) -> Pictures:
    """The standard views; what lies in the folder is not drawn again."""
    frame = annotation_frame(*box_of(record))
    cameras: dict[str, Any] = {}
    for view in STANDARD_VIEWS:
        lens, X_AC = camera(view, frame.extent), np.eye(4)
        X_AC[:3, :3], X_AC[:3, 3] = lens.R_NC, frame.centre_m + frame.unit_m * lens.position
        cameras[view.name] = X_AC.tolist()
    out.mkdir(parents=True, exist_ok=True)
    request = {
        "file": str(file.resolve()),
        "X_AB": X_AB.tolist(),
        "cameras": cameras,
        "fov_rad": FIELD_OF_VIEW_RAD,
        "size_px": SIZE_PX,
        "samples": SAMPLES,
        "seed": seed,
        "radius_m": LAMPS_AWAY * frame.unit_m,
        "out": str(out.resolve()),
    }
    text = json.dumps(request, indent=1)
    asked = out / "request.json"
    if not asked.exists() or asked.read_text() != text:
        asked.unlink(missing_ok=True)
        pending = out / "pending.json"
        pending.write_text(text)
        worker = Path(__file__).with_name("cycles_worker.py")
        done = subprocess.run(
            [str(program), "-I", str(worker), str(pending)], capture_output=True, text=True, timeout=_LIMIT_S, check=False
        )
        missing = [name for name in cameras if not (out / f"{name}.png").exists()]
        if done.returncode or missing:
            raise ValueError(f"Cycles drew no {missing}: {done.stderr[-300:]}")
        pending.rename(asked)
    return {view.name: _read(out / f"{view.name}.png") for view in STANDARD_VIEWS}


def drawn_by_mana(file: Path, X_AF: FloatArray, record: AssetRecord, work: Path) -> Pictures:
    """The standard views of what Mana reads; the alpha is that of any pixel that differs from the background."""
    model = read_model(file) if file.suffix in (".glb", ".gltf") else first_model(file)
    box = box_of(record)
    pictures = render_views(model.moved(X_AF), box, work, SIZE_PX)
    return {name: _opaque(data) for name, data in pictures.items()}


def _read(file: Path) -> tuple[FloatArray, FloatArray]:
    pixels = np.asarray(Image.open(file).convert("RGBA"), dtype=np.float32) / 255.0
    alpha = pixels[..., 3]
    # PNG holds colours that are not multiplied by alpha.
    return pixels[..., :3] * alpha[..., None] + BACKGROUND * (1.0 - alpha[..., None]), alpha


def flip(one: Pictures, other: Pictures) -> dict[str, float]:
    """Mean FLIP by view over the pixels that the object covers in either picture."""
    out = {}
    for name, (picture, alpha) in one.items():
        covered = np.maximum(alpha, other[name][1]) > COVERED
        out[name] = round(float(flip_map(picture, other[name][0])[covered].mean()), 4) if covered.any() else 0.0
    return out


def flip_map(one: FloatArray, other: FloatArray) -> FloatArray:
    """(h, w) FLIP of two sRGB pictures (h, w, 3)."""
    pictures = (np.ascontiguousarray(p, dtype=np.float32) for p in (one, other))
    return np.asarray(flip_evaluator.evaluate(*pictures, "LDR", applyMagma=False)[0])[..., 0]
