"""The shared assets against their manifest, as far as intake, canonicalize and appearance decide it.

`python -m benchmarks.assets.manifest` runs all rows through every stage; here each row costs a fraction of a second.
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

from assetkit.geometry.canonical_model import canonicalize
from assetkit.materials.normalize import normalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from tests.conftest import SHARED
from tests.support.peers import needs_blender

ASSETS = SHARED / "assets"
MAX_BYTES = 1_500_000
# The file is a clean closed surface; nothing of what its row names can be found in it.
MISLABELLED = {"tm_busted_stl"}
# Only the physics stage, which compares masses with the geometry, finds what the row names.
OF_PHYSICS = {"pb_lego_urdf", "pb_duck_vhacd_urdf"}
# Words of the manifest for what codes of robot descriptions call otherwise.
SYNONYMS = {
    "massless-moving-body": {"missing-inertial"},
    "missing-required-attribute": {"missing-attribute"},
    "duplicate-asset-name": {"duplicate-name"},
    "zero-mass-links": {"invalid-mass"},
    "zero-mass": {"invalid-mass"},
    "cyclic-reference": {"repeated-include", "link-cycle"},
    "dangling-reference": {"unknown-class"},
    "missing-dependency": {"missing-mesh"},
    "missing-joint-limit": {"missing-limit"},
    "invalid-axis": {"zero-axis"},
    "path-escape": {"xml-declarations"},
}
# Accepted files with true defects, which are repaired.
REPAIRED = {
    "bio_22_vertex_colors_and_attributes_blend": {"loose_geometry"},  # It shows attributes of points and edges too.
    "furn_oven_mjcf": {"self_intersection"},
    "pb_r2d2_urdf": {"hole_fill"},
    "pb_kuka_iiwa_urdf": {"hole_fill"},
    "libero_wooden_cabinet_mjcf": {"self_intersection"},
}


def rows() -> list[dict[str, str]]:
    if not (ASSETS / "manifest.csv").is_file():
        return []
    with (ASSETS / "manifest.csv").open() as file:
        planned = [r for r in csv.DictReader(file) if r["format"] != "other"]
    return [r for r in planned if int(r["bytes_total"]) <= MAX_BYTES and r["id"] not in MISLABELLED]


@pytest.fixture(scope="module")
def candidates(shared_assets):
    return {c.given: c for c in discover([shared_assets])}


@pytest.mark.shared
def test_the_manifest_is_found(shared_assets):
    assert len(rows()) > 80


@pytest.mark.shared
@pytest.mark.parametrize("row", [pytest.param(r, id=r["id"]) for r in rows()])
def test_row(row: dict[str, str], candidates):
    if row["format"] == "blend":
        needs_blender()
    taken = ReadSource().run(candidates[str(ASSETS / row["path"])], Options())
    codes = {d.code for d in taken.diagnostics if d.severity == "error"}
    repairs = {r.name for r in taken.repairs}
    volume = 0.0
    for item in taken.objects:
        outcome = canonicalize(item, row["path"].rsplit("/", 1)[-1], Options())
        codes |= {d.code for d in outcome.diagnostics if d.severity == "error"}
        repairs |= {r.name for r in (*outcome.repairs, *normalize(item.model).repairs)}
        if outcome.value is not None:
            volume += outcome.value.section.volume_m3.value
            assert np.isfinite(np.concatenate([m.points for m in outcome.value.meshes])).all()
    expected = {w.replace("_", "-") for w in row["reason"].split(";")}
    expected |= {synonym for word in expected for synonym in SYNONYMS.get(word, ())}
    if row["outcome"] == "reject":
        assert {c.partition("/")[2] for c in codes} & expected
        return
    assert not codes
    assert not taken.review
    if row["outcome"] == "repair":
        named = {r.replace("_", "-") for r in repairs} | {d.code.partition("/")[2] for d in taken.diagnostics}
        assert repairs or row["id"] in OF_PHYSICS
        assert (
            row["id"] in OF_PHYSICS or named & expected or expected <= {"scale-review", "texture-ktx2-or-missing-png"}
        )
    elif not row["reason"]:
        assert repairs <= REPAIRED.get(row["id"], set())
    if row["truth_volume_m3"]:
        assert volume == pytest.approx(float(row["truth_volume_m3"]), rel=0.005)
