"""Entry of the preview cell: reads one file or package and draws its first object in some modes, or a GIF.

It runs in a cell because the file may be anything, and a reader may hang or crash on it.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

from assetkit.geometry.canonical_model import canonicalize
from assetkit.library.animate_joints import animate_joints
from assetkit.library.validate import main_usd_files
from assetkit.materials.normalize import normalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from jobs.cache import write_atomically
from jobs.network import leave_network
from schemas.diagnostics import InvalidInput
from schemas.model import Model


def first_model(path: Path) -> Model:
    """The canonical model of the first object of a source file or of a package, with its mechanism.

    Raises InvalidInput when the file cannot be read and FileNotFoundError when a folder holds no USD file.
    """
    file, options = main_file(path), Options()
    taken = ReadSource().run(discover([file])[0], options)
    if not taken.objects:
        raise InvalidInput(taken.diagnostics[-1])
    item = taken.objects[0]
    canonical = canonicalize(item, file.name, options)
    if canonical.value is None:
        raise InvalidInput(canonical.diagnostics[-1])
    model = replace(item.model, meshes=canonical.value.meshes, mechanism=canonical.value.mechanism)
    appearance = normalize(model, canonical.value.meters_per_unit).value
    return replace(model, materials=appearance.materials if appearance else ())


def main_file(path: Path) -> Path:
    """The file itself, or the main USD file of a package. Raises FileNotFoundError for a folder without any."""
    files = main_usd_files(path) if path.is_dir() else [path]
    if not files:
        raise FileNotFoundError(path)
    return files[0]


def main(path: str, out: str, note: str, what: str, *rest: str) -> None:
    """Draw `path` into `out` and leave the files written, or why there are none, in `note`.

    `what` is "joints": `rest` is the number of frames, then names of joints or none, and `out` a GIF of these; or it is
    "modes": `rest` is the number of views, the size in pixels, then the modes.
    """
    from assetkit.library.draw_modes import draw_modes

    leave_network()
    source = Path(path)
    try:
        if what == "joints":
            written = [animate_joints(first_model(source), Path(out), int(rest[0]), rest[1:], source.name)]
        else:
            written = draw_modes(source, first_model(source), Path(out), rest[2:], int(rest[0]), int(rest[1]))
        reply = {"written": [str(p) for p in written]}
    except InvalidInput as refused:
        reply = {"refused": refused.diagnostic.model_dump(mode="json")}
    write_atomically(Path(note), json.dumps(reply).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
