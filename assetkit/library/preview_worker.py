"""Entry of the preview cell: reads one file or package and renders its first object to PNGs.

It runs in a cell because the file may be anything, and a reader may hang or crash on it.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

from assetkit.geometry.canonical_model import canonicalize
from assetkit.library.validate import main_usd_files
from assetkit.materials.normalize import normalize
from assetkit.options import Options
from assetkit.package.preview_images import render_previews
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from jobs.cache import write_atomically
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape
from usdio.reread.body import reread_package


def draw_preview(path: Path, out: Path) -> list[Path]:
    """Render the first object of a source file, or a package with its collision shapes; returns the PNGs written.

    Raises InvalidInput when the file cannot be read and FileNotFoundError when a folder holds no USD file.
    """
    shapes: tuple[CollisionShape, ...] = ()
    if path.is_dir():
        files = main_usd_files(path)
        if not files:
            raise FileNotFoundError(path)
        path = files[0]
        shapes = reread_package(path).body.shapes
    options = Options()
    taken = ReadSource().run(discover([path])[0], options)
    if not taken.objects:
        raise InvalidInput(taken.diagnostics[-1])
    item = taken.objects[0]
    canonical = canonicalize(item, path.name, options)
    if canonical.value is None:
        raise InvalidInput(canonical.diagnostics[-1])
    appearance = normalize(item.model).value
    materials = appearance.materials if appearance else ()
    model = replace(item.model, meshes=canonical.value.meshes, materials=materials)
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for name, data in render_previews(model, shapes, out).items():
        written.append(out / f"{name}.png")
        written[-1].write_bytes(data)
    return written


def main(path: str, out: str, note: str) -> None:
    """Draw `path` into `out` and leave the files written, or why there are none, in `note`."""
    try:
        reply = {"written": [str(p) for p in draw_preview(Path(path), Path(out))]}
    except InvalidInput as refused:
        reply = {"refused": refused.diagnostic.model_dump(mode="json")}
    write_atomically(Path(note), json.dumps(reply).encode())


if __name__ == "__main__":
    main(*sys.argv[1:4])
