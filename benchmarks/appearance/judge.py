"""Released packages beside their sources, drawn by Blender's Cycles and by Mana, compared by FLIP.

    python -m benchmarks.appearance.judge OUT [FILE.glb ...] [--assets DIR] [--only NAME ...]

Each sample is ingested as `mana assets ingest` does. Cycles draws the source, read by Blender's glTF importer, and the
released USD, read by Blender's USD importer, which takes the UsdPreviewSurface of a material and neither its MaterialX
nor its MDL: same cameras (the four standard views), same light (that of Mana's studio), same paths. Mana draws what its
readers make of the two. The source is brought into the asset frame by unit, axes and origin of the record; nothing is
aligned by pictures. FLIP is averaged over the pixels that the object touches in either picture (mask of Cycles).
*Noise* is the FLIP between two drawings of the source with other random numbers, in the front view.

OUT/table.md and results.json hold the figures, OUT/sheet.png the view of each sample that differs most, and
OUT/NAME/sheet.png all views. A second run draws only what changed. Exit code 1 where a view exceeds its target or a
sample could not be compared.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from assetkit.batch.report_file import read_items
from assetkit.library.validate import main_usd_files
from assetkit.package.record import read_record
from benchmarks.appearance import cycles, sheet
from benchmarks.appearance.flip import mean_flip
from benchmarks.appearance.own_pictures import draw_release, draw_source, lacking
from benchmarks.appearance.samples import Sample, samples
from benchmarks.appearance.table import Comparison, Refusal, table
from geom.pose import matrix_of
from render.camera import STANDARD_VIEWS, AnnotationFrame, annotation_frame
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord

OTHER_SEED = cycles.SEED + 1
NOISE_VIEWS = STANDARD_VIEWS[:1]  # one is enough to know how large it is


class NotCompared(Exception):
    """A sample without exactly one package, or with one that cannot be read."""


def main() -> int:
    """Compare the samples, write the results; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("files", type=Path, nargs="*", help="more glTF files")
    parser.add_argument("--assets", type=Path, help="folder of the development assets")
    parser.add_argument("--only", nargs="*", default=[], help="names of samples, or parts of them")
    options = parser.parse_args()
    listed = samples(options.out / "sources", options.assets, tuple(options.files))
    chosen = [each for each in listed if not options.only or any(part in each.name for part in options.only)]
    packages = ingested(chosen, options.out / "library")
    results: list[Comparison | Refusal] = []
    for sample in chosen:
        try:
            results.append(compare(sample, packages[sample.name], options.out / sample.name, cycles.Quality()))
        except (NotCompared, cycles.NotDrawn, subprocess.TimeoutExpired) as error:
            results.append(Refusal(sample.name, str(error)))
        print(results[-1].row(), flush=True)
    (options.out / "results.json").write_text(json.dumps([asdict(result) for result in results], indent=1) + "\n")
    text = table(results)
    (options.out / "table.md").write_text(text)
    print(text)
    compared = [result for result in results if isinstance(result, Comparison)]
    sheet.overview([options.out / result.name / "tile.png" for result in compared], options.out / "sheet.png")
    return 0 if results and all(isinstance(r, Comparison) and r.meets for r in results) else 1


def compare(sample: Sample, packages: Sequence[Path], out: Path, quality: cycles.Quality) -> Comparison:
    """Compare a sample with its one package. Raises NotCompared and cycles.NotDrawn."""
    if len(packages) != 1:
        raise NotCompared(f"{len(packages)} packages instead of one")
    package = packages[0]
    record = read_record(package)
    if record is None or record.appearance is None:
        raise NotCompared("the package has no readable record")
    release, frame = main_usd_files(package)[0], box_frame(record)
    X_AS = X_AS_of(record)
    X_AB = cycles.from_gltf(X_AS)
    source = cycles.draw(sample.source, X_AB, frame, out / "source", quality)
    again = cycles.draw(sample.source, X_AB, frame, out / "source_again", quality, OTHER_SEED, NOISE_VIEWS)
    released = cycles.draw(release, np.eye(4), frame, out / "release", quality)
    own_source = draw_source(sample.source, X_AS, frame, source, out, quality.size_px)
    own_release = draw_release(release, frame, released, out, quality.size_px)
    sheet.write(out / "sheet.png", sample.name, (source, released), (own_source, own_release))
    flips = mean_flip(source, released)
    sheet.tile(out / "tile.png", sample.name, source, released, flips)
    return Comparison(
        name=sample.name,
        outcome=record.outcome.value,
        apart=any(material.optics != "opaque" for material in record.appearance.render_materials),
        lacking=lacking(release),
        cycles=flips,
        noise=mean_flip(again, source),
        own=mean_flip(own_source, own_release),
        between=mean_flip(released, own_release),
    )


def ingested(chosen: Sequence[Sample], library: Path) -> dict[str, tuple[Path, ...]]:
    """The packages of each sample by its name, as the command line makes them. Raises NotCompared where it stops."""
    argv = [sys.executable, "-m", "cli.main", "assets", "ingest", *(str(each.source) for each in chosen)]
    done = subprocess.run([*argv, "--out", str(library)], check=False, capture_output=True, text=True)
    if done.returncode not in (0, 1):  # 1: some were rejected
        raise NotCompared(" ".join((done.stdout + done.stderr).split())[-300:])
    items = {Path(item.source).resolve(): item for item in read_items(library)}
    return {each.name: tuple(library / name for name in items[each.source.resolve()].packages) for each in chosen}


def X_AS_of(record: AssetRecord) -> FloatArray:
    """(4, 4) the asset frame from that of the source file, with the source's unit: p_A = X_AS p_S."""
    X_AS = np.eye(4)
    X_AS[:3, :3] = record.source.meters_per_unit.value * matrix_of(np.asarray(record.geometry.source_quat_wxyz))
    X_AS[:3, 3] = record.geometry.origin_offset_m
    return X_AS


def box_frame(record: AssetRecord) -> AnnotationFrame:
    """The annotation frame of the released asset."""
    frame, size_m = record.geometry.annotation_frame, np.asarray(record.geometry.extent_m.value)
    centre_m = np.asarray(frame.centre_m)
    return annotation_frame(centre_m - size_m / 2.0, centre_m + size_m / 2.0)


if __name__ == "__main__":
    sys.exit(main())
