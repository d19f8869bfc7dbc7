"""From mesh files to simulation packages: `assetkit.ingest`.

    python examples/01_ingest.py OUT

The sources are meshes that pybullet_data brings. Each becomes a folder in `OUT/library` with metric scale, repaired
geometry, collision shapes, mass and inertia, and was dropped in PyBullet; its `record.json` holds the source and the
confidence of every value. Examples 02 and 04 use these packages.
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
    """Ingest the meshes; print the outcome of each source and the mass of each package with its bounds."""
    data, library = Path(pybullet_data.getDataPath()), out / "library"
    options = assetkit.Options(license="Zlib", author="Bullet contributors")
    report = assetkit.ingest([data / mesh for mesh in MESHES], library, engine=SIMULATOR, options=options, root=data)
    for item in report.items:
        print(f"{Path(item.source).name}: {item.outcome}")
        for diagnostic in item.diagnostics:
            print(f"  {diagnostic.code}: {diagnostic.headline}")
        for package in item.packages:
            record = AssetRecord.model_validate_json((library / package / "record.json").read_bytes())
            mass_kg, shapes = record.physics.mass_kg, record.physics.collision_method
            low_kg, high_kg = mass_kg.bounds or (mass_kg.value, mass_kg.value)
            print(f"  {package}: {mass_kg.value:.3f} kg [{low_kg:.3f}, {high_kg:.3f}], collision shapes: {shapes}")
    print(f"{library / 'report.html'} shows all of them")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
