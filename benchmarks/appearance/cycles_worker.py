"""Runs in the Python of Blender, not of Mana: draws one file by Cycles from given cameras. Imports nothing of Mana.

    python -I cycles_worker.py REQUEST.json

The request: `file` (.glb, .gltf or .usd*), `X_NB` (4 x 4 rows: the drawing frame from that in which Blender imports,
with its scale), `cameras` (by name `X_NC`, looking along -z, and `azimuth_deg`, to which the light turns), `fov_rad`,
`size_px`, `samples`, `seed`, `environment` (an .npy of linear radiance (rows, columns): elevations from the nadir up,
azimuths from the viewer's side to the right), `lamps` (direction in camera axes, irradiance), `out` (a folder).
Written: NAME.png, sRGB by the view transform `Standard`, with the alpha of the object.
"""

import importlib
import json
import math
import os
import sys
from pathlib import Path

import numpy as np

bpy, mathutils = importlib.import_module("bpy"), importlib.import_module("mathutils")
GLTF = (".glb", ".gltf")
BOUNCES = 8  # Blender's default is 12; light that passes more than 8 surfaces of one object adds less than 8 bits show.


def imported(file, X_NB):
    """Read the file and put all of it below one empty that carries the frame."""
    if file.lower().endswith(GLTF):
        bpy.ops.import_scene.gltf(filepath=file, import_shading="NORMALS")
    else:
        bpy.ops.wm.usd_import(filepath=file, import_cameras=False, import_lights=False, import_guide=False)
    scene = bpy.context.scene
    frame = bpy.data.objects.new("frame", None)
    scene.collection.objects.link(frame)
    for thing in list(scene.objects):
        if thing.type in {"CAMERA", "LIGHT"}:
            bpy.data.objects.remove(thing)
        elif thing.parent is None and thing is not frame:
            thing.parent = frame
    frame.matrix_world = mathutils.Matrix(X_NB)
    bpy.context.view_layer.update()


def world_light(file):
    """A world lit by the picture of the environment; returns the node that turns it."""
    radiance = np.load(file).astype(np.float32)
    rows, columns = radiance.shape
    # Cycles reads azimuths clockwise from -x in the first column to -x in the last: column c lies at 180 - 360 c / n.
    turned = radiance[:, (columns // 2 - 1 - np.arange(columns)) % columns]
    image = bpy.data.images.new("environment", columns, rows, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((rows, columns, 4), dtype=np.float32)
    pixels[..., :3] = turned[..., None]
    image.pixels.foreach_set(pixels.ravel())
    world = bpy.data.worlds.new("environment")
    bpy.context.scene.world = world
    world.use_nodes = True
    # As fine as the picture; the automatic one costs a second before each drawing.
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", columns
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    where, turn, sky, shade, out = (
        nodes.new(f"ShaderNode{kind}")
        for kind in ("TexCoord", "Mapping", "TexEnvironment", "Background", "OutputWorld")
    )
    sky.image, sky.interpolation = image, "Linear"
    links.new(where.outputs["Generated"], turn.inputs["Vector"])
    links.new(turn.outputs["Vector"], sky.inputs["Vector"])
    links.new(sky.outputs["Color"], shade.inputs["Color"])
    links.new(shade.outputs["Background"], out.inputs["Surface"])
    return turn


def far_lamps(lamps):
    """One sun for each lamp: its object and its direction in camera axes."""
    suns = []
    for number, lamp in enumerate(lamps):
        data = bpy.data.lights.new(f"lamp {number}", "SUN")
        data.energy, data.angle = lamp["irradiance"], 0.0
        sun = bpy.data.objects.new(f"lamp {number}", data)
        bpy.context.scene.collection.objects.link(sun)
        suns.append((sun, mathutils.Vector(lamp["towards_C"])))
    return suns


def settings(scene, request):
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.seed = request["samples"], request["seed"]
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sampling_pattern = "BLUE_NOISE"  # less of the noise that FLIP sees, for as many paths
    scene.cycles.max_bounces = BOUNCES
    scene.render.film_transparent = True
    scene.render.threads_mode, scene.render.threads = "FIXED", request["threads"]
    scene.render.resolution_x = scene.render.resolution_y = request["size_px"]
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGBA"


def draw(request):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    imported(request["file"], request["X_NB"])
    turn, suns = world_light(request["environment"]), far_lamps(request["lamps"])
    settings(scene, request)
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", request["fov_rad"]
    data.clip_start, data.clip_end = 0.01, 100.0
    eye = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(eye)
    scene.camera = eye
    for name, camera in request["cameras"].items():
        eye.matrix_world = mathutils.Matrix(camera["X_NC"])
        turn.inputs["Rotation"].default_value = mathutils.Euler((0.0, 0.0, -math.radians(camera["azimuth_deg"])))
        for sun, towards_C in suns:
            towards_N = eye.matrix_world.to_3x3() @ towards_C
            sun.matrix_world = towards_N.to_track_quat("Z", "Y").to_matrix().to_4x4()
        scene.render.filepath = str(Path(request["out"]) / f"{name}.png")
        bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    draw(json.loads(Path(sys.argv[1]).read_text()))
    sys.stdout.flush()
    os._exit(0)  # Blender's own end prints errors of its add-ons.
