"""From mesh files to simulation packages: `assetkit.ingest`.

    python examples/01_ingest.py OUT

Sources are meshes that pybullet_data brings: files without units, one of them open. Each becomes a folder in
`OUT/library` with metric scale, collision shapes, mass and inertia, dropped in PyBullet; `record.json` holds the source
and the confidence of every value. The next examples use these packages.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pybullet_data

import assetkit
from schemas import AssetRecord

SIMULATOR = "sim.bullet.simulator:BulletSimulator"  # the engine that drops each package, by name
MESHES = ("objects/mug.obj", "tray/tray_textured.obj", "duck.obj", "domino/domino.obj")


def main(out: Path) -> None:
    """Ingest the meshes; print one line per source and the mass of each package with its origin."""
    data = Path(pybullet_data.getDataPath())
    library = out / "library"
    options = assetkit.Options(license="Zlib", author="Bullet contributors")
    report = assetkit.ingest([data / mesh for mesh in MESHES], library, engine=SIMULATOR, options=options, root=data)
    for item in report.items:
        print(f"{Path(item.source).name}: {item.outcome}, {', '.join(item.codes) or 'no findings'}")
        for package in item.packages:
            record = AssetRecord.model_validate_json((library / package / "record.json").read_bytes())
            print(f"  {package}: {record}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
