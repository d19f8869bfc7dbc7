"""Precision and recall of near-duplicates: `python -m benchmarks.library.near_duplicates ASSETS [KIND...]`.

Each of `OBJECTS` (below the folder ASSETS) is another object, some of the same category. Its copies are: turned, scaled
and with shuffled triangles; exported to OBJ with six digits and read again; with 90 % and 60 % of its triangles; a
mirror image, which is the same object only where it is mirror-symmetric, and is listed apart. `SECOND_SOURCES` are the
same objects from another place or in another format. Each copy is compared with every original whose descriptor is
near, and the originals with each other ("same file"). KINDs leave out the others.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.library.catalog.neighbours import NEAR_DESCRIPTOR
from assetkit.library.near_duplicates import SAME_SURFACE
from assetkit.library.preview_worker import first_model
from geom.features.shape_descriptor import descriptor_distances, shape_descriptor, vector_of
from geom.mesh.aligned_distance import aligned_distance
from geom.mesh.decimate import decimate
from geom.mesh.edit import merge_surfaces
from schemas.arrays import FloatArray, IntArray

Surface = tuple[FloatArray, IntArray]
REDUCED_SHARES = (0.9, 0.6)
LEAST_TRIANGLES = 200  # of what is decimated
TURN_DEG, SCALE = (40.0, -73.0, 110.0), 0.37
_HANDLE = "mjcf/libero_wooden_cabinet_mjcf/wooden_cabinet/wooden_cabinet_middle_handle/wooden_cabinet_middle_handle.obj"
_WHEEL = "usd/uwg_car_sedan/assets/wheels/wheel{0}/geo/wheel{0}Geo.{1}"
OBJECTS = (
    "dae/as_sphere_dae/sphere.dae",
    "dae/as_teapots_dae/teapots.DAE",
    "glb/genesis_camera_glb/camera.glb",
    "glb/gt_boxmeshopt_glb/BoxMeshopt.glb",
    "glb/gt_chr_knight_glb/chr_knight.glb",
    "glb/habitat_chair_glb/chair.glb",
    "glb/khr_duck_glb/Duck.glb",
    "glb/sapien_water_bottle_glb/water_bottle.glb",
    "glb/tm_boolean_glb/boolean.glb",
    "glb/tm_monkey_glb/monkey.glb",
    "gltf/drake_bin/bin.gltf",
    "gltf/drake_plate_8in/assets/plate_8in.gltf",
    "gltf/ph_painted_wooden_cabinet_02/painted_wooden_cabinet_02_1k.gltf",
    "gltf/ph_painted_wooden_stool/painted_wooden_stool_1k.gltf",
    "gltf/ph_sofa_03/sofa_03_1k.gltf",
    "mjcf/libero_flat_stove_mjcf/flat_stove/stove_burner/burnerplate.stl",
    _HANDLE,
    "obj/as_spider_obj/spider.obj",
    "obj/gso_frypan_obj/chefmate_8_frypan.obj",
    "obj/hope_ketchup_obj_cm/textured.obj",
    "obj/sapien_table_obj/visual_mesh.obj",
    "obj/tm_capsule_obj/capsule.obj",
    "obj/tm_chair_model_obj/chair_model.obj",
    "obj/tm_fuze_obj/fuze.obj",
    "obj/ycb_002_master_chef_can_obj/textured_simple_reoriented.obj",
    "obj/ycb_003_cracker_box_obj/textured_simple_reoriented.obj",
    "obj/ycb_010_potted_meat_can_obj/textured_simple_reoriented.obj",
    "obj/ycb_061_foam_brick_obj/textured_simple_reoriented.obj",
    "ply/tm_bunny_ply/bunny.ply",
    "stl/furn_wall_lamp_stl/wall_lamp.stl",
    "stl/tm_20mm-xyz-cube_stl/20mm-xyz-cube.stl",
    "stl/tm_angle_block_stl/angle_block.STL",
    "urdf/pb_lego_urdf/lego.obj",
    "urdf/pb_traybox_urdf/tray_textured.obj",
    "urdf/ycb_005_tomato_soup_can_urdf/textured_simple_reoriented.obj",
    "urdf/ycb_011_banana_urdf/textured_simple_reoriented.obj",
    _WHEEL.format("LargeRim", "usd"),
    _WHEEL.format("Normal", "usda"),
    _WHEEL.format("Red", "usd"),
    _WHEEL.format("Vintage", "usd"),
    "usd/uwg_teapot/geo/FancyTeapot.usd",
)
# The spider of as_spider_binary_stl is the mirror image of that of as_spider_obj (to 1e-5 of its size), so no copy.
SECOND_SOURCES = {
    "dae/khr_duck_dae/Duck.dae": "glb/khr_duck_glb/Duck.glb",
    "gltf/khr_duck_specgloss/Duck.gltf": "glb/khr_duck_glb/Duck.glb",
    "urdf/pb_duck_vhacd_urdf/duck.obj": "glb/khr_duck_glb/Duck.glb",
    "gltf/drake_010_potted_meat_can_gltf/010_potted_meat_can_textured.gltf": (
        "obj/ycb_010_potted_meat_can_obj/textured_simple_reoriented.obj"
    ),
    "mjcf/gso_chefmate_8_frypan_mjcf/chefmate_8_frypan.obj": "obj/gso_frypan_obj/chefmate_8_frypan.obj",
    "mjcf/hope_ketchup/textured.obj": "obj/hope_ketchup_obj_cm/textured.obj",
    "usd/tus_suzanne_usdc/suzanne.usdc": "glb/tm_monkey_glb/monkey.glb",
    "usd/tus_texturedcube_usda/texturedcube.usda": "glb/gt_boxmeshopt_glb/BoxMeshopt.glb",
}


def main(assets: Path, kinds: list[str]) -> None:
    """Prints recall per kind of copy, pairs reported that are no copies, and seconds."""
    originals = {name: surface_of(assets / name) for name in OBJECTS}
    queries = [
        (kind, name, copy)
        for name, surface in originals.items()
        for kind, copy in {"same file": surface, **copies_of(surface)}.items()
    ]
    queries += [("second source", of, surface_of(assets / name)) for name, of in SECOND_SOURCES.items()]
    queries = [query for query in queries if not kinds or query[0] in kinds]
    vectors = {name: vector(surface) for name, surface in originals.items()}
    counts: Counter[tuple[str, str]] = Counter()
    compared, started = 0, time.monotonic()
    for kind, name, copy in queries:
        distances = descriptor_distances(vector(copy), np.array(list(vectors.values())))
        counts[kind, "all"] += 1
        if distances[list(originals).index(name)] > NEAR_DESCRIPTOR:
            print(f"no candidate: {kind} of {name}")
        for other, distance in zip(originals, distances, strict=True):
            if distance > NEAR_DESCRIPTOR or (kind == "same file" and other <= name):
                continue
            compared += 1
            result = aligned_distance(*originals[other], *copy)
            if result.max_share <= SAME_SURFACE:
                counts[kind, "right" if other == name else "wrong"] += 1
                if other != name:
                    print(f"reported: {kind} of {name} as {other}, {result.max_share:.4f}")
            elif other == name and kind != "mirrored":
                print(f"missed: {kind} of {name}, {distance:.4f}, {result.max_share:.4f}")
    seconds = time.monotonic() - started
    for kind in dict.fromkeys(kind for kind, _, _ in queries):
        print(f"{kind}: {counts[kind, 'right']} of {counts[kind, 'all']} reported, {counts[kind, 'wrong']} wrong pairs")
    print(f"{len(originals)} objects, {compared} comparisons, {seconds / max(compared, 1):.2f} s each")


def surface_of(path: Path) -> Surface:
    """Points (n, 3) and triangles (m, 3) of the canonical meshes of a file."""
    points, triangles, _ = merge_surfaces(first_model(path.resolve()).meshes)
    return points, triangles


def vector(surface: Surface) -> FloatArray:
    """The vector of a surface's descriptor."""
    shape = shape_descriptor(*surface)
    assert shape is not None
    return vector_of(shape)


def copies_of(surface: Surface) -> dict[str, Surface]:
    """The copies of a surface by kind."""
    points, triangles = surface
    R = Rotation.from_euler("xyz", TURN_DEG, degrees=True).as_matrix()
    order = np.random.default_rng(0).permutation(len(triangles))
    copies = {
        "turned and scaled": (SCALE * points @ R.T + 1.0, triangles[order]),
        "exported again": exported(points, triangles),
        "mirrored": (points * np.array([1.0, -1.0, 1.0]), triangles[:, ::-1]),
    }
    if len(triangles) > LEAST_TRIANGLES:
        for share in REDUCED_SHARES:
            copies[f"{share:.0%} of triangles"] = decimate(points, triangles, int(share * len(triangles)))
    return copies


def exported(points: FloatArray, triangles: IntArray) -> Surface:
    """The surface as it comes back from an OBJ file in millimetres with y up, through reading and canonicalisation."""
    lines = [f"v {1000 * x:.6g} {1000 * z:.6g} {-1000 * y:.6g}" for x, y, z in points]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "copy.obj"
        file.write_text("\n".join(lines))
        return surface_of(file)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
