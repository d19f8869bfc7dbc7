"""Hostile inputs by what they try: references out of the folder, bombs, cycles, floods, odd values and odd files.

Every case is a folder of small files, the file that is read, and the codes of which at least one must come back. The
folder lies beside `outside`, which nothing may open (`tests.suites.fuzz.outside`).
"""

from __future__ import annotations

import io
import json
import struct
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from tests.support import replay_samples
from tests.support.bad_inputs.assets import CUBE, gltf_json, obj_text
from tests.support.bad_inputs.gap import FREE
from tests.support.bad_inputs.robot import link, shape

Files = dict[str, bytes]
UP, ABSOLUTE = "../outside/secret", "/@outside@/secret"
OBJ = obj_text(CUBE)
SCENE = "scene: s\nbackground: {asset: {type: box, size_m: [1, 1, 0.1]}}\n"
BOMB = (
    "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>"
    + "".join(f"<!ENTITY {b} '{f'&{a};' * 10}'>" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    + "]>"
)
LARGE = 40_000  # pixels a side


@dataclass(frozen=True)
class Hostile:
    """The files of a case, which of them is read, as what, and the codes that may answer."""

    format: str
    file: str
    files: Files
    codes: tuple[str, ...]

    def write(self, place: Path) -> tuple[Path, Path]:
        """The folder below `place` and the file to read."""
        for name, data in self.files.items():
            path = place / "case" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data.replace(b"/@outside@", str(place / "outside").encode()))
        return place / "case", place / "case" / self.file


def _case(format_name: str, file: str, text: str | bytes, *codes: str, **others: str | bytes) -> Hostile:
    named = {file: text, **{name.replace("___", "/").replace("__", "."): data for name, data in others.items()}}
    files = {name: data.encode() if isinstance(data, str) else data for name, data in named.items()}
    return Hostile(format_name, file, files, codes)


def _gltf(**changes: object) -> str:
    return json.dumps(gltf_json(**changes))


def _usda(body: str, metadata: str = "") -> str:
    return f'#usda 1.0\n(\n    defaultPrim = "R"\n    metersPerUnit = 1\n    upAxis = "Z"\n    {metadata}\n)\n{body}\n'


def _usdz(*entries: tuple[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as package:
        for name, data in entries:
            package.writestr(zipfile.ZipInfo(name), data, method)
    return out.getvalue()


def _png(width: int, height: int) -> bytes:
    header = b"IHDR" + struct.pack(">II", width, height) + b"\x08\x02\0\0\0"
    chunks = struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    return b"\x89PNG\r\n\x1a\n" + chunks + struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))


def _hdf5(kind: str) -> bytes:
    """A recording whose states lie in another file, or that declares 10^12 of them."""
    with io.BytesIO() as out:
        with h5py.File(out, "w") as file:
            demo = file.create_group("data/demo_0")
            demo.attrs["model_file"] = replay_samples.MODEL
            demo["actions"] = np.zeros((3, 7))
            if kind == "link":
                demo["states"] = h5py.ExternalLink(f"{UP}.hdf5", "/states")
            elif kind == "storage":
                demo.create_dataset("states", shape=(4, 4), dtype="f8", external=[(f"{UP}.bin", 0, 128)])
            elif kind == "virtual":
                layout = h5py.VirtualLayout(shape=(4, 4), dtype="f8")
                layout[:] = h5py.VirtualSource(f"{UP}.hdf5", "states", shape=(4, 4))
                demo.create_virtual_dataset("states", layout)
            else:
                demo.create_dataset("states", shape=(10**9, 10**3), chunks=(64, 64), dtype="f8")
        return out.getvalue()


def _robot(text: str) -> str:
    return f'<robot name="r">{text}</robot>'


_MESH = '<mesh filename="{}"/>'
_BODY = "<mujoco>{}<worldbody><body><geom {}/></body></worldbody></mujoco>"
_EMPTY = "asset/empty-geometry"
_ESCAPE = "asset/path-escape"

REFERENCES: dict[str, Hostile] = {
    f"{name}, {way}": case
    for way, to in (("up", UP), ("absolute", ABSOLUTE))
    for name, case in {
        "OBJ, material library": _case("obj", "p.obj", f"mtllib {to}.mtl\n{OBJ}", _ESCAPE),
        "MTL, texture": _case(
            "obj", "p.obj", f"mtllib m.mtl\nusemtl m\n{OBJ}", _ESCAPE, m__mtl=f"newmtl m\nmap_Kd {to}.png\n"
        ),
        "glTF, buffer": _case("gltf", "p.gltf", _gltf(buffers=[{"byteLength": 168, "uri": f"{to}.bin"}]), _ESCAPE),
        "glTF, image": _case(
            "gltf",
            "p.gltf",
            _gltf(
                images=[{"uri": f"{to}.png"}],
                textures=[{"source": 0}],
                materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            ),
            _ESCAPE,
        ),
        "USD, reference": _case("usd", "p.usda", _usda(f'def Xform "R" (references = @{to}.usda@) {{}}'), _ESCAPE),
        "USD, payload": _case("usd", "p.usda", _usda(f'def Xform "R" (payload = @{to}.usda@) {{}}'), _ESCAPE),
        "USD, sublayer": _case("usd", "p.usda", _usda('def Xform "R" {}', f"subLayers = [@{to}.usda@]"), _ESCAPE),
        "USDZ, entry": _case(
            "usdz", "p.usdz", _usdz((f"{to.replace(ABSOLUTE, '/etc/secret')}.usda", b"#usda 1.0\n")), _ESCAPE
        ),
        "URDF, mesh": _case("urdf", "p.urdf", _robot(link("a", shape(_MESH.format(f"{to}.obj")))), "robot/path-escape"),
        "MJCF, mesh": _case(
            "mjcf",
            "p.xml",
            _BODY.format(f'<asset><mesh name="m" file="{to}.obj"/></asset>', 'type="mesh" mesh="m"'),
            "robot/path-escape",
        ),
        "MJCF, include": _case(
            "mjcf", "p.xml", _BODY.format(f'<include file="{to}.xml"/>', 'size="1"'), "robot/path-escape"
        ),
        "scene, include": _case("scene", "p.yaml", f"include: {to}.yaml\n{SCENE}", "scene/path-escape"),
        "measurement, URDF": _case(
            "measurement",
            "measurement.yaml",
            FREE.replace("  box: {size_m: [0.1, 0.06, 0.04]}", f"  urdf: {to}.urdf"),
            "gap/path-escape",
        ),
        "measurement, mesh": _case(
            "measurement",
            "measurement.yaml",
            FREE.replace("  box: {size_m: [0.1, 0.06, 0.04]}", f"  mesh: {to}.obj"),
            "gap/path-escape",
            trajectories___t0__csv="t,px\n0,0\n",
        ),
    }.items()
} | {
    "episode, link to another file": _case("episode", "d.hdf5", _hdf5("link"), "replay/path-escape"),
    "episode, stored in another file": _case("episode", "d.hdf5", _hdf5("storage"), "replay/path-escape"),
    "episode, view of another file": _case("episode", "d.hdf5", _hdf5("virtual"), "replay/path-escape"),
}

BOMBS: dict[str, Hostile] = {
    "COLLADA, entities": _case("dae", "p.dae", BOMB + "<COLLADA>&i;</COLLADA>", "asset/resource-limit"),
    "URDF, entities": _case("urdf", "p.urdf", BOMB + '<robot name="r">&i;</robot>', "robot/xml-declarations"),
    "MJCF, entities": _case("mjcf", "p.xml", BOMB + "<mujoco>&i;</mujoco>", "robot/xml-declarations"),
    "COLLADA, file entity": _case(
        "dae", "p.dae", f'<!DOCTYPE r [<!ENTITY i SYSTEM "{UP}.xml">]><COLLADA>&i;</COLLADA>', _ESCAPE
    ),
    "URDF, file entity": _case(
        "urdf", "p.urdf", f'<!DOCTYPE r [<!ENTITY i SYSTEM "{UP}.xml">]><robot name="&i;"/>', "robot/xml-declarations"
    ),
    "scene, aliases": _case(
        "scene",
        "p.yaml",
        "x0: &x0 [1]\n" + "".join(f"x{i}: &x{i} [{', '.join([f'*x{i - 1}'] * 10)}]\n" for i in range(1, 12)),
        "scene/file-too-large",
    ),
    "USDZ, packed zeros": _case(
        "usdz",
        "p.usdz",
        _usdz(("a.png", bytes(2**28)), method=zipfile.ZIP_DEFLATED),
        "asset/resource-limit",
        "asset/parse-error",
    ),
    "USDZ in USDZ": _case(
        "usdz",
        "p.usdz",
        _usdz(("a.usdz", _usdz(("b.usdz", b"PK")))),
        _EMPTY,
        "asset/parse-error",
        "asset/wrong-content",
    ),
    "texture of 40k x 40k": _case(
        "obj",
        "p.obj",
        f"mtllib m.mtl\nusemtl m\n{OBJ}",
        "asset/resource-limit",
        m__mtl="newmtl m\nmap_Kd t.png\n",
        t__png=_png(LARGE, LARGE),
    ),
    "PLY, 4 billion vertices": _case(
        "ply",
        "p.ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
        b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\0\0\0\0",
        "asset/truncated",
    ),
    "STL, 4 billion faces": _case("stl", "p.stl", bytes(80) + b"\xff\xff\xff\xff" + bytes(50), "asset/truncated"),
    "glTF, 4 billion values": _case(
        "gltf",
        "p.gltf",
        _gltf(accessors=[{"componentType": 5126, "count": 4 * 10**9, "type": "VEC3"}] * 2),
        "asset/resource-limit",
        "asset/accessor-out-of-bounds",
    ),
    "episode, 10^12 values": _case("episode", "d.hdf5", _hdf5("huge"), "replay/unreadable", "replay/state-size"),
    "USD, 100,000 levels": _case("usd", "p.usda", _usda('def Xform "R" {' * 100_000), "asset/resource-limit"),
    "COLLADA, 100,000 levels": _case("dae", "p.dae", "<a>" * 100_000, "asset/parse-error"),
    "URDF, 100,000 levels": _case("urdf", "p.urdf", "<link>" * 100_000, "robot/unreadable"),
    "glTF, 100,000 levels": _case("gltf", "p.gltf", "[" * 100_000, "asset/parse-error"),
    "scene, 100,000 levels": _case("scene", "p.yaml", "[" * 100_000, "scene/file-too-large"),
    "plan, 100,000 levels": _case("plan", "plan.json", "[" * 100_000, "plan/unreadable"),
    "measurement, 100,000 levels": _case(
        "measurement", "measurement.yaml", "[" * 100_000, "gap/yaml-syntax", "gap/file-too-large"
    ),
}

CYCLES: dict[str, Hostile] = {
    "USD, references": _case(
        "usd", "p.usda", _usda('def Xform "R" (references = @./p.usda@</R>) {}'), "asset/cyclic-reference"
    ),
    "MJCF, include": _case(
        "mjcf", "p.xml", _BODY.format('<include file="p.xml"/>', 'size="1"'), "robot/repeated-include"
    ),
    "URDF, links": _case(
        "urdf",
        "p.urdf",
        _robot(
            '<link name="a"/><link name="b"/>'
            '<joint name="i" type="fixed"><parent link="a"/><child link="b"/></joint>'
            '<joint name="j" type="fixed"><parent link="b"/><child link="a"/></joint>'
        ),
        "robot/link-cycle",
    ),
    "glTF, nodes": _case(
        "gltf", "p.gltf", _gltf(nodes=[{"children": [0], "mesh": 0}]), "asset/cyclic-reference", "asset/schema-error"
    ),
    "scene, include": _case("scene", "p.yaml", "include: p.yaml\n", "scene/include-cycle"),
    "scene, alias": _case("scene", "p.yaml", "a: &a [1, *a]\n", "scene/file-too-large", "scene/yaml-syntax"),
}

NUMBERS: dict[str, Hostile] = {
    "OBJ, NaN": _case("obj", "p.obj", OBJ.replace("v ", "v nan ", 1), "asset/nonfinite-vertices", "asset/parse-error"),
    "OBJ, infinite": _case("obj", "p.obj", "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "asset/nonfinite-vertices"),
    "URDF, NaN": _case(
        "urdf",
        "p.urdf",
        _robot(link("a", shape('<box size="nan 1 1"/>'))),
        "robot/invalid-number",
        "robot/invalid-size",
        _EMPTY,
    ),
    "MJCF, infinite": _case("mjcf", "p.xml", _BODY.format("", 'size="inf"'), "robot/invalid-number"),
    "scene, NaN": _case("scene", "p.yaml", SCENE + "clearance: .nan\n", "scene/invalid-value"),
    "measurement, NaN": _case(
        "measurement", "measurement.yaml", FREE.replace("0.3", ".nan"), "gap/invalid-value", "gap/missing-file"
    ),
}

FORMATS = {
    "obj": "p.obj",
    "stl": "p.stl",
    "ply": "p.ply",
    "glb": "p.glb",
    "gltf": "p.gltf",
    "dae": "p.dae",
    "usd": "p.usda",
    "usdz": "p.usdz",
    "urdf": "p.urdf",
    "scene": "p.yaml",
    "plan": "plan.json",
    "episode": "d.hdf5",
    "measurement": "measurement.yaml",
}
GLB = b"glTF" + struct.pack("<II", 2, 12)  # the head of a binary glTF and nothing behind it
PDF = b"%PDF-1.7\n1 0 obj<<>>endobj\ntrailer<<>>\n%%EOF\n"
KINDS: dict[str, Hostile] = {
    **{f"{name}, 0 bytes": Hostile(name, file, {file: b""}, ()) for name, file in FORMATS.items() if name != "scene"},
    **{f"{name}, a PDF": Hostile(name, file, {file: PDF}, ()) for name, file in FORMATS.items()},
    **{
        f"{name}, random bytes": Hostile(name, file, {file: np.random.default_rng(1).bytes(5000)}, ())
        for name, file in FORMATS.items()
    },
    **{f"{name}, a ZIP": Hostile(name, file, {file: _usdz(("a.txt", b"x"))}, ()) for name, file in FORMATS.items()},
    "an OBJ named .stl": Hostile("stl", "p.stl", {"p.stl": OBJ.encode()}, ("asset/wrong-content", "asset/parse-error")),
    "a GLB named .obj": Hostile("obj", "p.obj", {"p.obj": GLB}, ("asset/wrong-content",)),
}
