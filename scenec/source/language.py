"""JSON Schema of the scene language: for editors, and to suggest the key that a misspelt one was meant to be."""

from __future__ import annotations

from functools import cache
from typing import Any

from schemas.scene.program import SceneProgram
from source.tree import Path, Scalar, Tree, TreeList, TreeMapping, child

JsonSchema = dict[str, Any]
SECTIONS = frozenset(SceneProgram.model_fields) - {"definition"}  # may also stand under `definition`
_RULES: JsonSchema = {
    "type": "object",
    "description": "over a list of the included file: `$append`, `$replace`, or ids of items to override",
    "properties": {"$append": {"type": "array"}, "$replace": {"type": "array"}, "include": True},
}
_INCLUDE: JsonSchema = {
    "description": "file or files, relative to this one, that are expanded here; the other keys lie over them",
    "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
}


def editor_schema() -> JsonSchema:
    """JSON Schema (2020-12) of authored files: the program, with `include` and overlay rules at any node."""
    schema = _as_written(_program_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Scene program"}


def keys_at(tree: Tree, path: Path) -> list[str]:
    """Allowed keys of the mapping at `path` of a program; empty where any key or no mapping is allowed."""
    root = schema = _program_schema()
    node: Tree | None = tree
    for depth, step in enumerate(path):
        schema = _branch(schema, node, root)
        if isinstance(step, int):
            prefix = schema.get("prefixItems", [])
            schema = prefix[step] if step < len(prefix) else schema.get("items", {})
        else:
            schema = schema.get("properties", {}).get(step, schema.get("additionalProperties", {}))
        node = child(tree, path[: depth + 1])
        if not isinstance(schema, dict):
            return []
    return list(_branch(schema, node, root).get("properties", {}))


@cache
def sections() -> dict[str, str]:
    """Paths of the keys one level below the program's own: `lighting` is `variants.lighting`."""
    root = _program_schema()
    below: dict[str, str] = {}
    for section, schema in root["properties"].items():
        for key in _branch(schema, None, root).get("properties", {}):
            below.setdefault(key, f"{section}.{key}")
    return {key: below[key] for key in below if below[key].split(".")[0] in ("layout", "variants", "split", "reach")}


@cache
def _program_schema() -> JsonSchema:
    return SceneProgram.model_json_schema()


def _branch(schema: JsonSchema, node: Tree | None, root: JsonSchema) -> JsonSchema:
    """The schema that applies to this value: references resolved, the alternative of its kind chosen."""
    if "$ref" in schema:
        return _branch(root["$defs"][schema["$ref"].removeprefix("#/$defs/")], node, root)
    if "discriminator" in schema:
        tag = child(node, ("type",))
        mapping = schema["discriminator"]["mapping"]
        known = isinstance(tag, Scalar) and tag.text in mapping
        return _branch({"$ref": mapping[tag.text]}, node, root) if known else {}  # pyright: ignore
    options = [_branch(option, node, root) for option in schema.get("anyOf", [])]
    kind = "object" if isinstance(node, TreeMapping) else "array" if isinstance(node, TreeList) else "string"
    return next((option for option in options if option.get("type") == kind), {}) if options else schema


def _as_written(schema: Any) -> Any:
    """The schema of a single file. Keys that it lacks may come from other files: nothing is required."""
    if isinstance(schema, list):
        return [_as_written(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    out: JsonSchema = {key: _as_written(value) for key, value in schema.items() if key not in ("required", "oneOf")}
    if "oneOf" in schema:  # Without required keys, more than one alternative may fit.
        out["anyOf"] = _as_written(schema["oneOf"])
    if schema.get("type") == "array":
        return {"anyOf": [out, _RULES], **{key: out.pop(key) for key in ("title", "default") if key in out}}
    if schema.get("type") == "object" and isinstance(schema.get("properties"), dict):
        out["properties"] = {**out["properties"], "include": _INCLUDE, "$delete": {"const": True}}
    return out
