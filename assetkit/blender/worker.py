"""Runs in the Python of Blender, not of Mana: looks into a .blend file, or converts it to GLB. Imports nothing of Mana.

    python -I worker.py look FILE ANSWER.json
    python -I worker.py convert FILE OUT.glb ROOT ANSWER.json

`look` parses blocks without Blender: version, libraries that the file links to, whether it ends where it should.
`convert` opens the file with scripts, drivers and handlers off and exports what is visible in renders. No picture that
lies outside ROOT is read.
"""

import gzip
import importlib
import json
import os
import re
import struct
import sys

ZSTD, GZIP = b"\x28\xb5\x2f\xfd", b"\x1f\x8b"
MOST_UNPACKED_BYTES = 2**31  # unpacked
_PATH = re.compile(rb"[\x20-\x7e\x80-\xff]{2,1023}\.blend\d*(?=\x00)", re.IGNORECASE)


def unpacked(path):
    """The bytes of the file, decompressed; fewer than there should be where it was cut off."""
    with open(path, "rb") as file:
        start = file.read(4)
        file.seek(0)
        if start[:2] == GZIP:
            source = gzip.GzipFile(fileobj=file)
        elif start == ZSTD:
            source = (
                importlib.import_module("zstandard").ZstdDecompressor().stream_reader(file, read_across_frames=True)
            )
        else:
            source = file
        chunks, size = [], 0
        try:
            while chunk := source.read(2**20):
                chunks.append(chunk)
                size += len(chunk)
                if size > MOST_UNPACKED_BYTES:
                    raise SystemExit("too large")
        except (OSError, EOFError, ValueError) as error:
            if not chunks:
                raise SystemExit(f"no blend file: {error}") from None
        except Exception as error:  # zstandard has an exception of its own.
            if not chunks:
                raise SystemExit(f"no blend file: {error}") from None
        return b"".join(chunks)


def look(path):
    """Version (248 for 2.48, 500 for 5.0), paths of linked libraries, and whether the last block is there."""
    data = unpacked(path)
    header = re.match(rb"BLENDER([_-])([vV])(\d{3})", data)
    later = re.match(rb"BLENDER(\d\d)-(\d\d)([vV])(\d{4})", data)
    if header:
        size, order, version, at = (4 if header[1] == b"_" else 8), header[2], int(header[3]), 12
    elif later:  # from 5.0 on
        size, order, version, at = 8, later[3], int(later[4]), int(later[1])
    else:
        return {"blend": False}
    end = "<" if order == b"v" else ">"
    libraries, complete = [], False
    long = later is not None and int(later[2]) >= 1
    layout = struct.Struct(f"{end}4siQqq") if long else struct.Struct(f"{end}4si{'Q' if size == 8 else 'I'}ii")
    while at + layout.size <= len(data):
        fields = layout.unpack_from(data, at)
        code, length = fields[0], (fields[3] if long else fields[1])
        at += layout.size
        if code == b"ENDB":
            complete = True
            break
        if length < 0 or at + length > len(data):
            break
        if code[:2] == b"LI":
            # The first path after the block's own name ("LI..."); what follows are copies of other machines.
            names = [name for name in _PATH.findall(data[at : at + length]) if name[:2] != b"LI"]
            libraries += [os.fsdecode(name).replace("\\", "/") for name in names[:1]]
        at += length
    return {"blend": True, "version": version, "complete": complete, "libraries": sorted(set(libraries))}


def convert(path, out, root):
    """Export to GLB, z up, in units of the scene; what was left out and which pictures are absent."""
    bpy = importlib.import_module("bpy")

    preferences = bpy.context.preferences
    preferences.filepaths.use_scripts_auto_execute = False
    bpy.app.driver_namespace.clear()
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as error:
        return {"error": str(error).strip()}
    for name in dir(bpy.app.handlers):
        handlers = getattr(bpy.app.handlers, name)
        if isinstance(handlers, list):
            handlers.clear()
    scene = bpy.context.scene
    meshes = [o for o in scene.objects if o.type in {"MESH", "CURVE", "SURFACE", "META", "FONT"}]
    shown = [o for o in meshes if not o.hide_render]
    used = {id(slot.material): slot.material for o in shown for slot in o.material_slots if slot.material}
    images, loose = {}, 0
    for material in used.values():
        collect(material.node_tree, images, set())
    escapes, absent = [], []
    for image in images.values():
        if image.source not in {"FILE", "SEQUENCE", "TILED"} or image.packed_file or image.packed_files:
            continue
        file = os.path.realpath(bpy.path.abspath(image.filepath, library=image.library))
        inside = file == root or file.startswith(root.rstrip(os.sep) + os.sep)
        if not inside:
            escapes.append(image.filepath)
        elif not os.path.isfile(file):
            absent.append(image.filepath)
    if escapes:
        return {"escapes": sorted(escapes)}
    for o in shown:
        if o.type == "MESH" and o.data:
            in_faces = {v for polygon in o.data.polygons for v in polygon.vertices}
            loose += len(o.data.vertices) - len(in_faces)
    read = [os.path.realpath(bpy.path.abspath(i.filepath, library=i.library)) for i in images.values()]
    units = scene.unit_settings
    answer = {
        "scale": float(f"{units.scale_length:.6g}") if units.system != "NONE" else None,
        "system": units.system,
        "absent": sorted(absent),
        "hidden": len(meshes) - len(shown),
        "loose": loose,
        "read": sorted({file for file in read if os.path.isfile(file)}),
        "texts": len(bpy.data.texts),
        "actions": len(bpy.data.actions),
    }
    if not shown:
        return {**answer, "empty": True}
    bpy.ops.export_scene.gltf(
        filepath=out,
        export_format="GLB",
        export_yup=False,
        export_apply=True,
        export_animations=False,
        export_skins=False,
        export_morph=False,
        export_cameras=False,
        export_lights=False,
        export_extras=False,
        use_renderable=True,
        use_active_scene=True,
        export_vertex_color="ACTIVE",
        export_tangents=False,
    )
    return answer


def collect(tree, images, visited):
    """Images of the nodes that reach an output of a node tree, and of the groups among them."""
    if tree is None or tree.name_full in visited:
        return
    visited.add(tree.name_full)
    waiting = [node for node in tree.nodes if node.type in {"OUTPUT_MATERIAL", "GROUP_OUTPUT"} or is_gltf(node)]
    reached = set()
    while waiting:
        node = waiting.pop()
        if node.name in reached:
            continue
        reached.add(node.name)
        if getattr(node, "image", None) is not None:
            images[node.image.name_full] = node.image
        collect(getattr(node, "node_tree", None), images, visited)
        waiting += [link.from_node for socket in node.inputs for link in socket.links]


def is_gltf(node):
    """Whether the node is the group that takes what only glTF has, such as occlusion."""
    return node.type == "GROUP" and node.node_tree is not None and node.node_tree.name.lower().startswith("gltf")


if __name__ == "__main__":
    result = look(sys.argv[2]) if sys.argv[1] == "look" else convert(*sys.argv[2:5])
    with open(sys.argv[-1], "w") as note:
        json.dump(result, note)
    sys.stdout.flush()
    os._exit(0)  # Blender's own end prints errors of its add-ons.
