"""Small package contents for the tests of writer, gate and twin."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from schemas.appearance.material import Material, Texture, TextureUse
from schemas.evidence import Evidence, declared
from schemas.model import Axis, Mesh, Model
from schemas.package import PackageContent
from schemas.physics import CollisionShape, Contact, MassProperties


def png(color: tuple[int, ...] = (200, 30, 30), mode: str = "RGB") -> bytes:
    data = io.BytesIO()
    Image.new(mode, (4, 4), color).save(data, "PNG")
    return data.getvalue()


def jpeg() -> bytes:
    data = io.BytesIO()
    Image.new("RGB", (4, 4), (1, 2, 3)).save(data, "JPEG")
    return data.getvalue()


def mesh_from(source: trimesh.Trimesh, name: str = "mesh", **fields: Any) -> Mesh:
    return Mesh(name, np.array(source.vertices, dtype=np.float64), np.array(source.faces, dtype=np.int32), **fields)


def box_mesh(size=(0.1, 0.08, 0.06), name: str = "body", shift=(0.0, 0.0, 0.0), **fields: Any) -> Mesh:
    box = trimesh.creation.box(size)
    box.apply_translation(np.array([0.0, 0.0, size[2] / 2]) + shift)
    return mesh_from(box, name, **fields)


def uvs(mesh: Mesh, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random((len(mesh.triangles), 3, 2), dtype=np.float32)


def colors(mesh: Mesh, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random((len(mesh.triangles), 3, 4), dtype=np.float32)


def model(meshes, materials=(), textures=()) -> Model:
    up: Evidence[Axis] = Evidence(value="z", source="declared", method="test")
    units = declared(1.0, "test"), up
    return Model(tuple(meshes), tuple(materials), tuple(textures), (), *units).with_mesh_ids()


def at(z_m: float, x_m: float = 0.0) -> np.ndarray:
    X_AS = np.eye(4)
    X_AS[:3, 3] = (x_m, 0.0, z_m)
    return X_AS


def hull_shape(mesh: Mesh) -> CollisionShape:
    hull = trimesh.Trimesh(mesh.points, mesh.triangles, process=False).convex_hull
    return CollisionShape("hull", (), np.eye(4), np.array(hull.vertices), np.array(hull.faces, dtype=np.int32))


def content(model_: Model, shapes=None, mass_kg: float | None = None, **fields: object) -> PackageContent:
    """Content with the mass properties of the solid bounding box at 500 kg/m3 and one box collider."""
    points = np.concatenate([mesh.points for mesh in model_.meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    edges, centre = np.maximum(high - low, 1e-4), (low + high) / 2
    mass = mass_kg if mass_kg is not None else 500.0 * float(np.prod(edges))
    inertia = mass / 12.0 * np.diag(np.sum(edges**2) - edges**2)
    pose = np.eye(4)
    pose[:3, 3] = centre
    box = CollisionShape("box", tuple(float(v) for v in edges), pose)
    base = PackageContent(
        asset_id="sample-1",
        model=model_,
        shapes=(box,) if shapes is None else tuple(shapes),
        mass=MassProperties(mass, centre, inertia),
        contact=Contact(static_friction=0.5, dynamic_friction=0.4, restitution=0.1),
        physical_material="wood",
        density_kgm3=500.0,
        category="unknown",
        qcode="unknown",
        license="unknown",
        author="unknown",
        source_file="sample.glb",
        thumbnail_png=png(),
    )
    return replace(base, **fields)


PICTURE = Texture("picture", png(), "png", 4, 4)
PHOTO = Texture("Föto 1", jpeg(), "jpg", 4, 4)


def full_material() -> Material:
    """Every input textured, with transforms, wraps, packed channels, alpha from the colour image."""
    packed = "Föto 1"
    return Material(
        name="Alles dran",
        base_color=(0.5, 0.6, 0.7),
        base_color_texture=TextureUse("picture", uv_scale=(2.0, 3.0), uv_rotation_rad=0.3, uv_offset=(0.1, 0.2)),
        metallic=1.0,
        metallic_texture=TextureUse(packed, channel="b"),
        roughness=1.0,
        roughness_texture=TextureUse(packed, channel="g"),
        normal_texture=TextureUse("picture", uv_set=1),
        occlusion_texture=TextureUse(packed, channel="r", scale=0.8, bias=0.2),
        emissive=(0.2, 0.3, 0.4),
        emissive_texture=TextureUse("picture", wrap_s="clamp", wrap_t="mirror"),
        opacity=0.9,
        opacity_texture=TextureUse("picture", channel="a"),
        alpha_mode="mask",
        alpha_cutoff=0.25,
        double_sided=True,
        ior=1.45,
        clearcoat=0.2,
        clearcoat_roughness=0.1,
    )


def full_content() -> PackageContent:
    body = box_mesh(name="body", material=0, source_path="/scene/body/mesh_0")
    body = replace(body, uvs=(uvs(body), uvs(body, 1)))
    return content(model([body], [full_material()], [PICTURE, PHOTO]))


def variants() -> dict[str, PackageContent]:
    """One content per thing that has gone wrong in some exporter."""
    body = box_mesh()
    colored = replace(body, colors=colors(body))
    textured = Material("t", base_color_texture=TextureUse("picture"), base_color=(1.0, 1.0, 1.0))
    blend = Material("b", alpha_mode="blend", opacity=0.5)
    card = mesh_from(trimesh.Trimesh([[-1, 0, 0], [1, 0, 0], [1, 0, 2], [-1, 0, 2]], [[0, 1, 2], [0, 2, 3]]), "card")
    ball = mesh_from(trimesh.creation.icosphere(2, 0.05), "ball")
    ball = replace(ball, points=ball.points + np.array([0.0, 0.0, 0.05]))
    names = ["same", "same", "Same", "1st", "größe", "机器", "", "a/b.c d", "collider_00"]
    row = [box_mesh(name=name, shift=(0.2 * i - 0.8, 0.0, 0.0)) for i, name in enumerate(names)]
    many = [
        box_mesh((0.01, 0.01, 0.01), f"part {i}", (0.02 * (i % 10) - 0.09, 0.02 * (i // 10) - 0.09, 0.0))
        for i in range(100)
    ]
    shapes = (
        CollisionShape("box", (0.1, 0.08, 0.06), at(0.03)),
        CollisionShape("sphere", (0.03,), at(0.03)),
        CollisionShape("capsule", (0.02, 0.02), at(0.03)),
        CollisionShape("cylinder", (0.03, 0.06), at(0.03)),
        hull_shape(body),
    )
    inward = np.repeat(-trimesh.Trimesh(body.points, body.triangles).face_normals[:, None], 3, axis=1)
    broken = np.zeros((12, 3, 3), dtype=np.float32)
    broken[0] = np.nan
    return {
        "plain": content(model([body])),
        "everything textured": full_content(),
        "texture without uvs": content(model([replace(body, material=0)], [textured], [PICTURE])),
        "vertex colours": content(model([colored])),
        "vertex colours and texture": content(
            model([replace(colored, material=0, uvs=(uvs(body),))], [textured], [PICTURE])
        ),
        "one material with and without colours": content(
            model([replace(colored, material=0), box_mesh((0.1, 0.1, 0.1), "other", material=0)], [blend])
        ),
        "glass": content(model([replace(body, material=0)], [Material("glass", transmission=1.0, ior=1.5)])),
        "every collider kind": content(model([body]), shapes),
        "box hull on its own box": content(model([body]), [hull_shape(body), replace(hull_shape(body))]),
        "hull listed like the visible box": content(
            model([body]), [CollisionShape("hull", (), np.eye(4), body.points, body.triangles)]
        ),
        "the same mesh twice": content(model([body, body])),
        "the same shape in two materials": content(
            model([body, replace(body, material=0)], [Material("decal", alpha_mode="blend", opacity=0.3)])
        ),
        "flat card": content(model([card])),
        "awkward names": content(model(row, [Material("1 é"), Material("")])),
        "tiny": content(model([box_mesh((0.001, 0.0008, 0.0006))])),
        "huge": content(model([box_mesh((400.0, 300.0, 50.0))])),
        "thirty hulls": content(model([ball]), [hull_shape(ball)] * 30),
        "hundred meshes": content(model(many)),
        "empty mesh beside a full one": content(
            model([body, Mesh("void", np.zeros((0, 3)), np.zeros((0, 3), np.int32))])
        ),
        "normals against the winding": content(model([replace(body, normals=inward.astype(np.float32))])),
        "broken normals": content(model([replace(body, normals=broken)])),
        "id that starts with a digit": content(model([body]), asset_id="3d-benchy_x"),
        "known origin": content(model([body]), category="mug", qcode="Q386215", license="CC0-1.0", author="Ada"),
    }
