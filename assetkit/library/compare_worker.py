"""Entry of the cell that compares packages: reads pairs, writes one line of JSON with the figures of each."""

from __future__ import annotations

import json
import sys
from functools import lru_cache
from pathlib import Path

from assetkit.library.validate import main_usd_files
from geom.mesh.aligned_distance import aligned_distance
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import InvalidInput
from usdio.reread.body import reread_package

DIGITS = 6  # of the figures that are stored
_SURFACES = 64  # Held in memory: pairs come in the order of their first asset.


def main(out: str, request: str, results: str) -> None:
    """Compare the pairs of asset ids in the file `request`; each line of `results` is flushed when it is known."""
    pairs = json.loads(Path(request).read_text())
    with Path(results).open("w") as file:
        for first, second in pairs:
            file.write(json.dumps(_comparison(Path(out) / first, Path(out) / second)) + "\n")
            file.flush()


def _comparison(first: Path, second: Path) -> dict[str, float | str]:
    try:
        result = aligned_distance(*_surface(first), *_surface(second))
    except (InvalidInput, ValueError, OSError) as error:
        return {"failure": type(error).__name__}
    names = ("scale_ratio", "mean_share", "p95_share", "max_share")
    return {name: round(float(getattr(result, name)), DIGITS) for name in names}


@lru_cache(maxsize=_SURFACES)
def _surface(package: Path) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) of the rendered meshes of a package, as its USD files hold them."""
    files = main_usd_files(package)
    if not files:
        raise FileNotFoundError(package)
    content = reread_package(files[0])
    return content.visual_points, content.visual_triangles


if __name__ == "__main__":
    main(*sys.argv[1:])
