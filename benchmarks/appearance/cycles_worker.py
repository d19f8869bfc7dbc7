"""Runs in the Python of Blender, not of Mana: draws one file by Cycles from given cameras. Imports nothing of Mana.

    python -I cycles_worker.py REQUEST.json

The request: `file` (.glb, .gltf or .usd*), `X_AB` (the asset frame from that in which Blender imports, 4 x 4 rows),
`cameras` by name (X_AC, looking along -z, metres), `fov_rad`, `size_px`, `samples`, `seed`, `radius_m` (of the lamps'
distance), `out` (a folder). Written: NAME.png in sRGB; its alpha is that of the object, glass is opaque in it.
"""

import importlib
import json
import math
import os
import sys
from pathlib import Path

bpy = importlib.import_module("bpy")
mathutils = importlib.import_module("mathutils")

# Light from around, grey at the horizon and brighter above, and three lamps: reflections have something to show.
LOW, HIGH = (0.12, 0.12, 0.13, 1.0), (0.55, 0.55, 0.55, 1.0)
LAMPS = (("key", (40.0, 50.0), 1.0), ("fill", (-60.0, 25.0), 0.4), ("rim", (170.0, 40.0), 0.6))  # azimuth, elevation
LAMP_W_PER_M2 = 6.0  # of a lamp at a distance of 1 m


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def imported(file, X_AB):
    """Reads the file below one empty that carries the pose."""
    if file.lower().endswith((".glb", ".gltf")):
        bpy.ops.import_scene.gltf(filepath=file, import_shading="NORMALS")
    else:
        bpy.ops.wm.usd_import(filepath=file, import_cameras=False, import_lights=False, import_guide=False)
    frame = bpy.data.objects.new("frame", None)
    bpy.context.scene.collection.objects.link(frame)
    for thing in list(bpy.context.scene.objects):
        if thing.parent is None and thing is not frame:
            thing.parent = frame
    frame.matrix_world = mathutils.Matrix(X_AB)
    bpy.context.view_layer.update()


def light(radius_m):
    """The same light for every file: only the distance of the lamps follows the object's size."""
    world = bpy.data.worlds.new("around")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    where, split, ramp = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ"), nodes.new("ShaderNodeMix")
    ramp.data_type = "RGBA"
    shade, out = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    half = nodes.new("ShaderNodeMath")
    half.operation, half.inputs[1].default_value, half.inputs[2].default_value = "MULTIPLY_ADD", 0.5, 0.5
    links.new(where.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["Z"], half.inputs[0])
    links.new(half.outputs[0], ramp.inputs["Factor"])
    ramp.inputs[6].default_value, ramp.inputs[7].default_value = LOW, HIGH
    links.new(ramp.outputs[2], shade.inputs["Color"])
    links.new(shade.outputs[0], out.inputs["Surface"])
    for name, (azimuth, elevation), share in LAMPS:
        data = bpy.data.lights.new(name, "AREA")
        data.size, data.energy = 0.8 * radius_m, share * LAMP_W_PER_M2 * radius_m**2
        lamp = bpy.data.objects.new(name, data)
        a, e = math.radians(azimuth), math.radians(elevation)
        towards = mathutils.Vector((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))
        lamp.matrix_world = (
            mathutils.Matrix.Translation(radius_m * towards) @ towards.to_track_quat("Z", "Y").to_matrix().to_4x4()
        )
        bpy.context.scene.collection.objects.link(lamp)


def settings(scene, request):
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.seed = request["samples"], request["seed"]
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 8
    scene.render.film_transparent = True
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x = scene.render.resolution_y = request["size_px"]
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"


def draw(request):
    scene = empty_scene()
    imported(request["file"], request["X_AB"])
    light(request["radius_m"])
    settings(scene, request)
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", request["fov_rad"]
    data.clip_start, data.clip_end = 0.01 * request["radius_m"], 10.0 * request["radius_m"]
    eye = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(eye)
    scene.camera = eye
    for name, X_AC in request["cameras"].items():
        eye.matrix_world = mathutils.Matrix(X_AC)
        scene.render.filepath = str(Path(request["out"]) / f"{name}.png")
        bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    draw(json.loads(Path(sys.argv[1]).read_text()))
    sys.stdout.flush()
    os._exit(0)  # Blender's own end prints errors of its add-ons.
