"""Packages beside their sources, drawn by Blender's Cycles and by Mana, compared by FLIP.

    python -m benchmarks.appearance.judge OUT [--assets DIR] [--only NAME ...]

Each sample is ingested as `mana assets ingest` does. Cycles draws the source, read by Blender's own glTF importer, and
the released USD, read by Blender's own USD importer, with the same cameras (the four standard views) and light
(`cycles_worker`). Mana draws the model that its reader makes of the source, and the one that it reads back. Frames are
those that the record states; nothing is aligned by pictures. FLIP (Andersson et al., 2020; its authors' library) is
averaged over the pixels that the object covers in either picture. Both drawings of Cycles have the same seed, so what
noise is left is alike. OUT holds a table (`table.md`), `results.json` and a sheet per sample.
"""

from __future__ import annotations

import argparse
import io
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import flip_evaluator
import numpy as np
from PIL import Image

from assetkit.blender import environment
from assetkit.library.validate import main_usd_files
from assetkit.package.preview_images import render_views
from assetkit.package.record import read_record
from benchmarks.appearance.made_materials import MADE, made_glb
from benchmarks.assets.heavy_scans import read_model
from geom.pose import matrix_of
from render.camera import FIELD_OF_VIEW_RAD, STANDARD_VIEWS, annotation_frame, camera
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput
from schemas.model import Mesh

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
SIZE_PX, SAMPLES, SEED = 192, 24, 1
LAMPS_AWAY = 3.0  # in largest edges of the box
BACKGROUND = 0.5  # sRGB grey behind the object, the same in all pictures
COVERED = 0.5  # alpha
MOST_PER_VIEW, MOST_MEDIAN = 0.10, 0.05
TO_NATIVE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # glTF's axes from Blender's
_LIMIT_S = 900.0
Pictures = dict[str, tuple[FloatArray, FloatArray]]  # by view: sRGB (h, w, 3) over the background, alpha (h, w)


@dataclass(frozen=True)
class Judged:
    """Mean FLIP of source and release by view: by Cycles, by Mana."""

    name: str
    apart: bool
    cycles: dict[str, float]
    mana: dict[str, float]

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
    for name, row in MADE.items():
        made = place / name / f"{name}.glb"
        made.parent.mkdir(exist_ok=True)
        made.write_bytes(made_glb(name))
        yield name, made, row["apart"]


def judged(program: Path, name: str, source: Path, out: Path, apart: bool) -> Judged:
    """Ingests a sample and compares its release with it. Raises ValueError where there is no package."""
    package = ingested(source, out / "library")
    record = read_record(package)
    if record is None:
        raise ValueError("no record")
    release, X_AS = main_usd_files(package)[0], asset_from_source(record)
    X_AB = X_AS.copy()
    X_AB[:3, :3] = X_AS[:3, :3] @ TO_NATIVE
    before = drawn_by_cycles(program, source, X_AB, record, out / "source")
    after = drawn_by_cycles(program, release, np.eye(4), record, out / "release")
    mine = drawn_by_mana(source, X_AS, record, out), drawn_by_mana(release, np.eye(4), record, out)
    covered = {name: np.maximum(alpha, after[name][1]) for name, (_, alpha) in before.items()}
    by_mana = tuple({name: (picture, covered[name]) for name, (picture, _) in pictures.items()} for pictures in mine)
    _sheet(before, after, *mine).save(out / "sheet.png")
    return Judged(name, apart, flip(before, after), flip(*by_mana))


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


def drawn_by_cycles(program: Path, file: Path, X_AB: FloatArray, record: AssetRecord, out: Path) -> Pictures:
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
        "seed": SEED,
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
            [str(program), "-I", str(worker), str(pending)],
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
        missing = [name for name in cameras if not (out / f"{name}.png").exists()]
        if done.returncode or missing:
            raise ValueError(f"Cycles drew no {missing}: {done.stderr[-300:]}")
        pending.rename(asked)
    return {view.name: _read(out / f"{view.name}.png") for view in STANDARD_VIEWS}


def drawn_by_mana(file: Path, X_AF: FloatArray, record: AssetRecord, work: Path) -> Pictures:
    """The standard views of what Mana reads from a file whose frame is F."""
    model = read_model(file)
    meshes = tuple(_moved(mesh, X_AF) for mesh in model.meshes)
    pictures = render_views(replace(model, meshes=meshes), box_of(record), work, SIZE_PX)
    return {name: _on_floor(data) for name, data in pictures.items()}


def _moved(mesh: Mesh, X_AF: FloatArray) -> Mesh:
    points = mesh.points @ X_AF[:3, :3].T + X_AF[:3, 3]
    if mesh.normals is None:
        return replace(mesh, points=points)
    scale = np.cbrt(np.linalg.det(X_AF[:3, :3]))
    return replace(mesh, points=points, normals=(mesh.normals @ (X_AF[:3, :3] / scale).T).astype(np.float32))


def _on_floor(data: bytes) -> tuple[FloatArray, FloatArray]:
    """Mana draws a floor under the object: all pixels count."""
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=np.float64) / 255.0
    return pixels, np.ones(pixels.shape[:2])


def _read(file: Path) -> tuple[FloatArray, FloatArray]:
    pixels = np.asarray(Image.open(file).convert("RGBA"), dtype=np.float64) / 255.0
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
    first, second = np.ascontiguousarray(one, dtype=np.float32), np.ascontiguousarray(other, dtype=np.float32)
    errors, _, _ = flip_evaluator.evaluate(first, second, "LDR", applyMagma=False)
    return np.asarray(errors, dtype=np.float64)[..., 0]


def _sheet(*drawn: Pictures) -> Image.Image:
    """Rows: source and release by Cycles, their FLIP, the same by Mana; a column for each view."""
    before, after, mine_before, mine_after = drawn
    rows = [before, after, _differences(before, after), mine_before, mine_after, _differences(mine_before, mine_after)]
    sheet = Image.new("RGB", (SIZE_PX * len(before), SIZE_PX * len(rows)))
    for y, row in enumerate(rows):
        for x, (picture, _) in enumerate(row.values()):
            pixels = np.round(255.0 * np.clip(picture, 0.0, 1.0)).astype(np.uint8)
            sheet.paste(Image.fromarray(pixels), (SIZE_PX * x, SIZE_PX * y))
    return sheet


def _differences(one: Pictures, other: Pictures) -> Pictures:
    """FLIP as a grey picture by view: white is 1."""
    return {
        name: (np.repeat(flip_map(picture, other[name][0])[..., None], 3, axis=2), alpha)
        for name, (picture, alpha) in one.items()
    }


def table(results: Sequence[Judged]) -> str:
    """Markdown: a row per sample, those of glass and coats below, then what the targets make of them."""
    lines = [
        "| sample | Cycles: mean | worst view | Mana: mean | worst view |",
        "|---|---|---|---|---|",
    ]
    plain, apart = ([r for r in results if r.apart is which] for which in (False, True))
    lines += [_row(r) for r in sorted(plain, key=lambda r: -r.mean)]
    lines += [_row(r) for r in sorted(apart, key=lambda r: -r.mean)]
    if plain:
        over = [r.name for r in plain if r.worst > MOST_PER_VIEW]
        median = float(np.median([r.mean for r in plain]))
        lines += [
            "",
            f"{len(plain)} samples without glass and coats: median {median:.4f} (target {MOST_MEDIAN}); "
            f"{len(over)} with a view above {MOST_PER_VIEW}{': ' + ', '.join(over) if over else ''}.",
        ]
    return "\n".join(lines) + "\n"


def _row(result: Judged) -> str:
    mana = result.mana.values()
    figures = (
        result.mean,
        result.worst,
        float(np.mean(list(mana))),
        max(mana),
    )
    name = f"{result.name} (apart)" if result.apart else result.name
    return f"| {name} | " + " | ".join(f"{figure:.4f}" for figure in figures) + " |"


if __name__ == "__main__":
    sys.exit(main())
