"""The rows of one record in the tables of the catalog, by table name, without the key of the asset."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from assetkit.library.search.facts import Facts, facts_of, texts_of
from geom.features.shape_descriptor import MOMENTS, QUANTILES, vector_of
from jobs.cache import content_key
from schemas.asset import AssetRecord, ShapeDescriptor

Row = tuple[object, ...]
UNKNOWN = "unknown"
_GEOMETRY_FILES = (".usda", ".usdc", ".usd")  # of a package, without twins, pictures and textures


def rows_of(record: AssetRecord, sha256: str) -> dict[str, list[Row]]:
    """All rows of a record; `sha256` is that of its file."""
    facts = facts_of(record)
    return {
        "assets": [_asset(record)],
        "traits": sorted(_traits(record, facts)),
        "records": [(sha256, record.schema_version, facts.model_dump_json())],
        "sources": [(k, f.path, f.sha256, f.bytes) for k, f in enumerate(record.source.files)],
        "words": [texts_of(record)],
        "shapes": [_shape(record, shape) for shape in (record.geometry.shape,) if shape is not None and _usable(shape)],
    }


def digest_of(shape: ShapeDescriptor) -> str:
    """Equal for surfaces with equal descriptors, whatever their scale."""
    return content_key(vector_of(shape).tolist())


def _asset(record: AssetRecord) -> Row:
    semantics, physics, source = record.semantics, record.physics, record.source
    extent = record.geometry.extent_m
    group = semantics.interaction_group
    capacities = [a.value.volume_m3 for a in record.anchors if a.value.kind == "volume"]
    return (
        record.asset_id,
        semantics.name,
        record.outcome.value,
        semantics.category.value,
        semantics.family.value,
        UNKNOWN if group is None else group.value,
        ",".join(r.value for r in semantics.roles),
        source.license.value,
        source.license.source,
        source.license.method,
        source.author.value,
        source.generator,
        source.format,
        *extent.value,
        max(extent.value),
        physics.mass_kg.value,
        physics.material.value,
        physics.collision_method,
        record.geometry.reobserved.triangles,
        len(physics.joints),
        len(record.anchors) - len(capacities),
        len(capacities),
        max(capacities, default=0.0),
        extent.confidence,
        physics.mass_kg.confidence,
    )


def _traits(record: AssetRecord, facts: Facts) -> Iterable[Row]:
    """(field, value, confidence), each field and value once with its highest confidence."""
    best: dict[tuple[str, str], float] = {}
    for field, value, confidence in _listed_traits(record, facts):
        best[field, value] = max(confidence, best.get((field, value), 0.0))
    return ((field, value, confidence) for (field, value), confidence in best.items())


def _listed_traits(record: AssetRecord, facts: Facts) -> Iterable[tuple[str, str, float]]:
    yield "outcome", facts.outcome, 1.0
    yield "category", facts.category.value, facts.category.confidence
    yield "family", facts.family.value, facts.family.confidence
    yield from (("hypothesis", name, chance) for name, chance in facts.possible[:1])
    yield from (("role", role.value, role.confidence) for role in facts.roles)
    yield from (("material", material.value, material.confidence) for material in facts.materials)
    yield from (("colour", colour, share) for colour, share in (facts.colours or {}).items())
    yield from (("anchor", anchor.value, anchor.confidence) for anchor in facts.anchors)
    yield from (("task", task.value, task.confidence) for task in facts.tasks)
    yield from (("part", part, 1.0) for part in facts.parts)
    yield from (("joint", str(joint.value.get("type", UNKNOWN)), joint.confidence) for joint in record.physics.joints)
    if record.semantics.interaction_group is not None:
        group = record.semantics.interaction_group
        yield "group", group.value, group.confidence
    yield from (("group", use.group.value, use.group.confidence) for use in record.joint_uses)


def _usable(shape: ShapeDescriptor) -> bool:
    """Whether a descriptor has as many figures as those of this version, all finite."""
    vector = vector_of(shape)
    return len(vector) == MOMENTS + QUANTILES and bool(np.isfinite([*vector, shape.scale_m]).all())


def _shape(record: AssetRecord, shape: ShapeDescriptor) -> Row:
    """Digest and scale of the descriptor, the digest of the files with the geometry, and the descriptor's vector."""
    files = {name: sha for name, sha in record.hashes.items() if name.endswith(_GEOMETRY_FILES)}
    return (digest_of(shape), shape.scale_m, content_key(sorted(files.items())), vector_of(shape).tobytes())
