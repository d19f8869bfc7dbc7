"""The smallest input for every diagnostic code: `SAMPLES[code](folder)` writes it and returns the file to ingest.

Codes that no file can trigger are in `assets_without_a_file`, with the test that triggers them.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from tests.support.appearance.normal_maps import bumps, normal_map

Writer = Callable[[Path], Path]

CUBE = trimesh.creation.box((0.1, 0.1, 0.1))
SPHERE = trimesh.creation.icosphere(subdivisions=2, radius=0.05)


def obj_text(mesh: trimesh.Trimesh, head: str = "") -> str:
    points = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices)
    return head + points + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.faces)


def lying_cup(floor_m: float) -> trimesh.Trimesh:
    """A cup of 80 by 95 mm that lies with its opening along -y."""
    profile = [[0, 0], [0.04, 0], [0.04, 0.095], [0.036, 0.095], [0.036, floor_m], [0, floor_m]]
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0))
    return trimesh.creation.revolve(np.array(profile), sections=32, transform=turn)


LYING_CUP = lying_cup(0.004)


def text(name: str, content: str | bytes) -> Writer:
    def write(folder: Path) -> Path:
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def obj(mesh: trimesh.Trimesh, head: str = "") -> Writer:
    return text("part.obj", obj_text(mesh, head))


def knob_called_lid(folder: Path) -> Path:
    """Two cubes; one node is called a lid and its material a knob."""
    points = "".join(
        f"v {x:.9g} {y:.9g} {z:.9g}\n" for k in (0.0, 0.1) for x, y, z in np.add(CUBE.vertices, (k, 0.0, 0.0))
    )
    faces = ["".join(f"f {a + k} {b + k} {c + k}\n" for a, b, c in CUBE.faces) for k in (1, 9)]
    (folder / "part.mtl").write_text("newmtl knob\nKd 1 0 0\nnewmtl steel\nKd 0 1 0\n")
    head = f"mtllib part.mtl\n{points}"
    return text("part.obj", f"{head}o lid\nusemtl knob\n{faces[0]}o base\nusemtl steel\n{faces[1]}")(folder)


def gltf_json(**changes: Any) -> dict[str, Any]:
    """A cube as glTF with an embedded buffer; `changes` replace top-level keys."""
    points = CUBE.vertices.astype("<f4").tobytes()
    indices = CUBE.faces.astype("<u2").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(points + indices).decode()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "m"}],
        "buffers": [{"byteLength": len(points) + len(indices), "uri": uri}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)},
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 8,
                "type": "VEC3",
                "min": [-0.05] * 3,
                "max": [0.05] * 3,
            },
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
    }
    return document | changes


def gltf(**changes: Any) -> Writer:
    return text("part.gltf", json.dumps(gltf_json(**changes)))


def textured(image: dict[str, Any], **changes: Any) -> Writer:
    material = {"name": "m", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    return gltf(materials=[material], textures=[{"source": 0}], images=[image], **changes)


def usda(metadata: str = 'metersPerUnit = 1\n    upAxis = "Z"', body: str = "", default: str = "Root") -> Writer:
    points = ", ".join(f"({x:.9g}, {y:.9g}, {z:.9g})" for x, y, z in CUBE.vertices)
    faces = ", ".join(str(i) for i in CUBE.faces.ravel())
    counts = ", ".join(["3"] * len(CUBE.faces))
    return text(
        "part.usda",
        f'#usda 1.0\n(\n    defaultPrim = "{default}"\n    {metadata}\n)\n'
        'def Xform "Root"\n{\n    def Mesh "m"\n    {\n'
        f"        point3f[] points = [{points}]\n        int[] faceVertexCounts = [{counts}]\n"
        f"        int[] faceVertexIndices = [{faces}]\n    }}\n{body}}}\n",
    )


def moved(mesh: trimesh.Trimesh, *offset: float) -> trimesh.Trimesh:
    copy = mesh.copy()
    copy.apply_translation(offset)
    return copy


def joined(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    whole = trimesh.util.concatenate(meshes)
    assert isinstance(whole, trimesh.Trimesh)
    return whole


def faces_of(mesh: trimesh.Trimesh, faces: np.ndarray) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def soup() -> trimesh.Trimesh:
    corners = np.random.default_rng(0).uniform(0, 0.3, (40, 3, 3))
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(120).reshape(-1, 3), process=False)


def fin() -> trimesh.Trimesh:
    points = np.vstack([SPHERE.vertices, [[0.0, 0.0, 0.12]]])
    return trimesh.Trimesh(points, np.vstack([SPHERE.faces, [*SPHERE.faces[0][:2], len(points) - 1]]), process=False)


def bowtie() -> trimesh.Trimesh:
    other = moved(CUBE, 0.1, 0.1, 0.1)
    corner = int(np.argmin(np.linalg.norm(other.vertices - CUBE.vertices.max(axis=0), axis=1)))
    both = joined(CUBE, other)
    shared = int(np.argmax(CUBE.vertices.sum(axis=1)))
    return faces_of(both, np.where(both.faces == 8 + corner, shared, both.faces))


def lidless() -> trimesh.Trimesh:
    box = trimesh.creation.box((0.3, 0.2, 0.15))
    return faces_of(box, box.faces[(box.vertices[box.faces][:, :, 2] < 0).any(axis=1)])


def cut_corner() -> trimesh.Trimesh:
    """A dense cube that lost a corner: a hole that is filled, but the corner is anyone's guess."""
    dense = CUBE.subdivide().subdivide().subdivide()
    return faces_of(dense, dense.faces[np.linalg.norm(dense.triangles_center - 0.05, axis=1) > 0.02])


def crossing_bar() -> trimesh.Trimesh:
    """A square bar bent back through itself: one closed surface, whose crossing is enclosed twice."""
    path = np.array([[0, 0], [0.1, 0], [0.1, 0.1], [0.05, 0.1], [0.05, -0.05]])
    step = np.diff(path, axis=0) / np.linalg.norm(np.diff(path, axis=0), axis=1)[:, None]
    left = np.stack([-step[:, 1], step[:, 0]], axis=1)
    side = 0.01 * np.concatenate([left[:1], left[:-1] + left[1:], left[-1:]])  # Mitred at right angles.
    flat = np.stack([path - side, path + side, path + side, path - side], axis=1)
    points = np.concatenate([flat, np.broadcast_to([[-0.01], [-0.01], [0.01], [0.01]], (5, 4, 1))], axis=2)
    ring = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    quads = np.concatenate([4 * i + np.array(ring) for i in range(4)] + [[[3, 2, 1, 0], [16, 17, 18, 19]]])
    return trimesh.Trimesh(points.reshape(-1, 3), quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3), process=False)


def dirty() -> trimesh.Trimesh:
    """Many duplicates, slivers and extra sheets at once."""
    rng = np.random.default_rng(1)
    faces = SPHERE.faces
    doubled = faces[rng.integers(0, len(faces), 80)]
    slivers = np.column_stack([faces[:60, 0], faces[:60, 0], faces[:60, 1]])
    stray = rng.integers(0, len(SPHERE.vertices), (60, 3))
    stray = stray[(stray[:, 0] != stray[:, 1]) & (stray[:, 1] != stray[:, 2]) & (stray[:, 0] != stray[:, 2])]
    return faces_of(SPHERE, np.vstack([faces, doubled, slivers, stray]))


GLB_CUT = struct.pack("<4sIII4s", b"glTF", 2, 4096, 2048, b"JSON") + b'{"asset": {"ver'
BOMB = (
    "<!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'>]>"
    "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><asset>&b;</asset></COLLADA>"
)
JOINT = """    def Cube "a" {}
    def Cube "b" {}
    def PhysicsRevoluteJoint "hinge"
    {
        rel physics:body0 = </Root/a>
        rel physics:body1 = </Root/b>
    }
"""
HEAVY = """    def Cube "heavy" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        double size = 0.1
        float physics:mass = 1000
    }
"""
KHR = "KHR_physics_rigid_bodies"
LFS = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n"
ANIMATION = {
    "samplers": [{"input": 2, "output": 0}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
}
SOUND_FACES = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def mtl(content: str) -> Writer:
    def write(folder: Path) -> Path:
        (folder / "part.mtl").write_text(content)
        return text("part.obj", "mtllib part.mtl\nusemtl m\n" + SOUND_FACES)(folder)

    return write


def with_coordinates(*places: str) -> str:
    """SOUND_FACES, their corners at these texture coordinates in turn."""
    corners = iter(range(12))
    lines = [
        " ".join([word if word == "f" else f"{word}/{next(corners) % len(places) + 1}" for word in line.split()])
        if line.startswith("f")
        else line
        for line in SOUND_FACES.splitlines()
    ]
    return "".join(f"vt {place}\n" for place in places) + "\n".join(lines) + "\n"


def pictured(faces: str) -> Writer:
    """Faces in a material with a picture of 32 pixels a side, whose brightness follows nothing."""

    def write(folder: Path) -> Path:
        Image.new("RGB", (32, 32), (90, 120, 150)).save(folder / "part.png")
        (folder / "part.mtl").write_text("newmtl m\nmap_Kd part.png\n")
        return text("part.obj", "mtllib part.mtl\nusemtl m\n" + faces)(folder)

    return write


def green_down(folder: Path) -> Path:
    """Faces with a normal map of round bumps, as DirectX has it."""
    Image.fromarray(normal_map(bumps(64), green=-1.0)).save(folder / "part.png")
    (folder / "part.mtl").write_text("newmtl m\nnorm part.png\n")
    return text("part.obj", "mtllib part.mtl\nusemtl m\n" + with_coordinates("0 0", "1 0", "0 1"))(folder)


SAMPLES: dict[str, Writer] = {
    "asset/format-unsupported": text("part.fbx", b"Kaydara FBX Binary"),
    "asset/wrong-content": text("part.glb", "<!DOCTYPE html><html>404</html>"),
    "asset/lfs-pointer": text("part.glb", LFS),
    "asset/parse-error": text("part.gltf", '{"asset": '),
    "asset/schema-error": gltf(nodes="none"),
    "asset/truncated": text("part.glb", GLB_CUT),
    "asset/accessor-out-of-bounds": gltf(
        accessors=[{"bufferView": 0, "componentType": 5126, "count": 10**9, "type": "VEC3"}] * 2
    ),
    "asset/index-out-of-range": text("part.obj", SOUND_FACES + "f 1 2 99\n" + "f 1 2 98\n"),
    "asset/missing-dependency": gltf(buffers=[{"byteLength": 168, "uri": "absent.bin"}]),
    "asset/cyclic-reference": gltf(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]),
    "asset/unsupported-required-extension": gltf(extensionsRequired=["ACME_x"], extensionsUsed=["ACME_x"]),
    "asset/path-escape": text("part.obj", "mtllib ../../secret.mtl\n" + SOUND_FACES),
    "asset/remote-reference": gltf(buffers=[{"byteLength": 168, "uri": "http://127.0.0.1:9/x.bin"}]),
    "asset/resource-limit": text("part.dae", BOMB),
    "asset/empty-geometry": text("part.obj", "# nothing\n"),
    "asset/no-faces": text("part.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"),
    "asset/nonfinite-vertices": text("part.obj", SOUND_FACES.replace("v 0.1 0 0", "v nan 0 0")),
    "asset/degenerate-geometry": text("part.obj", "v 0 0 0\nv 0.1 0 0\nv 0.2 0 0\nf 1 2 3\n"),
    "asset/triangle-soup": obj(soup()),
    "asset/scale-implausible": obj(CUBE.copy().apply_scale(1e-8)),
    "asset/several-objects": obj(joined(CUBE, moved(CUBE, 1.0, 0.0, 0.0))),
    "asset/articulated-source": usda(body=JOINT),
    "asset/unit-mismatch": obj(CUBE.copy().apply_scale(1000), "# units: mm\n"),
    "asset/scale-unverified": obj(CUBE.copy().apply_scale(20)),
    "asset/up-axis-mismatch": obj(CUBE, "# exported y-up\n"),
    "asset/geometry-left-out": usda(body='    def NurbsPatch "p" {}\n'),
    "asset/up-axis-unverified": obj(CUBE),
    "asset/contradictory-evidence": gltf(nodes=[{"mesh": 0, "scale": [1800, 1800, 1800]}]),
    "asset/invalid-unit-value": usda("metersPerUnit = 0"),
    "asset/invalid-up-axis": usda('metersPerUnit = 1\n    upAxis = "X"'),
    "asset/invalid-default-prim": usda(default="Absent"),
    "asset/far-from-origin": obj(moved(CUBE, 1e6, 0.0, 0.0)),
    "asset/inverted-winding": obj(faces_of(SPHERE, SPHERE.faces[:, ::-1])),
    "asset/degenerate-faces": obj(faces_of(SPHERE, np.vstack([SPHERE.faces, [[0, 0, 1]], SPHERE.faces[:2]]))),
    "asset/small-holes": obj(faces_of(SPHERE, SPHERE.faces[1:])),
    "asset/non-manifold-edge": obj(fin()),
    "asset/non-manifold-left": obj(joined(CUBE, moved(CUBE, 0.1, 0.0, 0.0))),
    "asset/non-manifold-vertex": obj(bowtie()),
    "asset/duplicate-shell": obj(joined(SPHERE, SPHERE)),
    "asset/overlapping-bodies": obj(joined(CUBE, moved(CUBE, 0.05, 0.02, 0.0))),
    "asset/open-shell": obj(lidless()),
    "asset/dirty-mesh": obj(dirty()),
    "asset/loose-fragments": obj(
        joined(SPHERE, moved(faces_of(CUBE.copy().apply_scale(0.005), CUBE.faces[:3]), 0.06, 0.0, 0.0))
    ),
    "asset/repair-distorts": obj(cut_corner()),
    "asset/self-intersection": obj(crossing_bar()),
    "asset/too-many-triangles": obj(trimesh.creation.icosphere(subdivisions=4, radius=0.05)),
    "asset/bad-normals": text("part.obj", "vn 0 0 0\n" + SOUND_FACES.replace("f 1 3 2", "f 1//1 3//1 2//1")),
    "asset/empty-face": text("part.obj", SOUND_FACES + "f\n"),
    "asset/nonfinite-colors": text("part.obj", SOUND_FACES.replace("v 0 0 0\n", "v 0 0 0 nan 0 0\n")),
    "asset/missing-texture": textured({"uri": "absent.png"}),
    "asset/corrupt-texture": textured(
        {"uri": "data:image/png;base64," + base64.b64encode(b"\x89PNG\r\n\x1a\n").decode()}
    ),
    "asset/unsupported-texture": textured(
        {"uri": "data:image/ktx2;base64," + base64.b64encode(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(64)).decode()}
    ),
    "asset/missing-material": text("part.obj", "mtllib absent.mtl\nusemtl m\n" + SOUND_FACES),
    "asset/invalid-material-value": mtl("newmtl m\nNs shiny\n"),
    "asset/material-extension-fallback": gltf(
        materials=[{"name": "m", "extensions": {"KHR_materials_unlit": {}}}], extensionsUsed=["KHR_materials_unlit"]
    ),
    "asset/normal-map-green-down": green_down,
    "asset/shader-lacks-layer": gltf(
        materials=[
            {
                "name": "m",
                "pbrMetallicRoughness": {"metallicFactor": 0.0},
                "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}},
            }
        ],
        extensionsUsed=["KHR_materials_transmission"],
    ),
    "asset/missing-texture-coordinates": pictured(SOUND_FACES),
    "asset/collapsed-texture-coordinates": pictured(with_coordinates("0.5 0.5")),
    "asset/nonfinite-texture-coordinates": pictured(with_coordinates("0 0", "1 0", "nan 1")),
    "asset/texture-resampled": pictured(with_coordinates("0 0", "1 0", "0 1")),
    "asset/source-inertia-implausible": usda(body=HEAVY),
    "asset/source-friction-implausible": gltf(
        nodes=[{"mesh": 0, "extensions": {KHR: {"collider": {"geometry": {"node": 0}, "physicsMaterial": 0}}}}],
        extensions={KHR: {"physicsMaterials": [{"staticFriction": 0.2, "dynamicFriction": 0.4}]}},
    ),
    "asset/animation-dropped": gltf(animations=[ANIMATION]),
    "asset/category-unknown": obj(CUBE),
    "asset/out-of-domain": text("car.obj", obj_text(trimesh.creation.box((4.5, 1.8, 1.5)))),
    "asset/part-disputed": knob_called_lid,
    "asset/turned-upright": text("mug.obj", obj_text(LYING_CUP)),
    "asset/upright-uncertain": text("mug.obj", obj_text(lying_cup(0.06))),
    "asset/category-contradicted": text("mug.obj", obj_text(trimesh.creation.box((2.0, 2.0, 3.0)))),
}
