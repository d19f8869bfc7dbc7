"""Read glTF 2.0 (.gltf and .glb) into a Model: geometry baked into the model frame, materials, textures, provenance."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assetkit.readers.common.corners import Notes
from assetkit.readers.gltf.buffers import Buffers
from assetkit.readers.gltf.container import parse_container
from assetkit.readers.gltf.extensions import check_required
from assetkit.readers.gltf.geometry import Geometry
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.material_layers import with_scaled_volume
from assetkit.readers.gltf.materials import read_material
from assetkit.readers.gltf.nodes import place_nodes
from assetkit.readers.gltf.physics import GltfPhysics
from assetkit.readers.gltf.textures import Textures
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Material
from schemas.diagnostics import Location, finding
from schemas.evidence import declared
from schemas.model import Axis, Mesh, Model
from schemas.outcome import Outcome

_UP: Final[Axis] = "y"
_HINT_NAMES: Final = 8
_METADATA: Final = ("author", "copyright", "generator", "license", "source", "title")


def read_gltf(source: SourceFile) -> Outcome[Model]:
    """The model in a .gltf or .glb file: points in the model frame (glTF axes: y up, +z forward), metres.

    One Mesh per node and primitive, and per copy where a node draws several. Skinned meshes have the pose their
    joints are stored in, morph targets keep their default weights, material variants their default; cameras and
    lights are left out.
    Raises InvalidInput for every fatal finding; repaired ones are in the outcome.
    """
    extension = source.path.suffix.lower().removeprefix(".")
    document, chunk = parse_container(source.path.read_bytes(), extension, Location(file=source.relative))
    check_required(document)
    buffers = Buffers(source, document, chunk)
    placed = place_nodes(document)
    geometry = Geometry(document, buffers)
    meshes, nodes, notes = geometry.bake(placed)
    physics = GltfPhysics(document, placed, nodes, meshes)
    textures = Textures(source, document, buffers)
    materials, meshes, material_notes = _read_materials(document, meshes, textures, geometry.scales_of_material)
    notes += textures.notes + material_notes + _animation_notes(document) + Notes(physics.joints())
    model = Model(
        meshes=meshes,
        materials=materials,
        textures=tuple(textures.loaded),
        nodes=nodes,
        meters_per_unit=declared(1.0, "glTF 2.0 §3.4"),
        up_axis=declared(_UP, "glTF 2.0 §3.4"),
        hints=_hints(document),
        metadata=_metadata(document),
        masses=physics.masses(),
        contacts=physics.contacts(),
    )
    return Outcome(model, notes.diagnostics, notes.repairs)


def _read_materials(
    document: Json, meshes: tuple[Mesh, ...], textures: Textures, scales: dict[int, list[float]]
) -> tuple[tuple[Material, ...], tuple[Mesh, ...], Notes]:
    """The materials that `meshes` use, in file order, and `meshes` with `material` counting among these."""
    described = document.items("materials")
    used = sorted({mesh.material for mesh in meshes if mesh.material is not None})
    materials: list[Material] = []
    notes = Notes()
    for index in used:
        name = described[index].string("name", "") or f"material_{index}"
        material, material_notes = read_material(described[index], name, textures)
        materials.append(with_scaled_volume(material, scales[index]))
        notes += material_notes
    renumbered = {index: i for i, index in enumerate(used)}
    return (
        tuple(materials),
        tuple(m if m.material is None else replace(m, material=renumbered[m.material]) for m in meshes),
        notes,
    )


def _animation_notes(document: Json) -> Notes:
    counts = {"animations": len(document.items("animations")), "skins": len(document.items("skins"))}
    named = [key for key, count in counts.items() if count]
    if not named:
        return Notes()
    what = " and ".join(f"{counts[key]} {key}" for key in named)
    headline = f"{what} are left out; meshes stand in their stored pose"
    where = document.require(named[0]).where
    return Notes((finding("asset/animation-dropped", headline, where=where, value=counts[named[0]]),))


def _hints(document: Json) -> tuple[str, ...]:
    """Generator, copyright, extras of asset and scenes, names of nodes and meshes: they may state units or axes."""
    asset = document.object("asset")
    holders = (asset, *document.items("scenes")[:_HINT_NAMES])
    extras = (e.value for holder in holders if (e := holder.get("extras")) is not None and isinstance(e.value, dict))
    extra_texts = (
        f"{key}: {value}" for e in extras for key, value in e.items() if isinstance(value, str | int | float)
    )
    names = (n.string("name", "") for key in ("nodes", "meshes") for n in document.items(key)[:_HINT_NAMES])
    return tuple(t for t in (asset.string("generator", ""), asset.string("copyright", ""), *extra_texts, *names) if t)


def _metadata(document: Json) -> dict[str, str]:
    """Author, license and the like from `asset` and, as Sketchfab and others write it, from `asset.extras`."""
    asset = document.object("asset")
    extras = asset.get("extras")
    loose = extras.value if extras is not None and isinstance(extras.value, dict) else {}
    stated = {key.lower(): value for key, value in {**loose, **asset.value}.items()}
    return {key: stated[key] for key in _METADATA if isinstance(stated.get(key), str) and stated[key]}
