"""Defects of the file as a whole: units, prims, dependencies, size, labels, metadata."""

from __future__ import annotations

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics

from tests.suites.gate.edits import (
    CABINET,
    PROP,
    Defect,
    Sound,
    after_release,
    both,
    cabinet,
    label,
    metadata,
    on_prim,
    place,
    prop,
    put,
    texture_of,
    unapply,
)


def _picture(path: str) -> Sdf.AssetPath:
    return texture_of("metallic", lambda prim: prim.GetAttribute("inputs:file").Set(Sdf.AssetPath(path)))


DEFECTS: tuple[Defect, ...] = (
    prop("metersPerUnit missing", lambda s: s.ClearMetadata("metersPerUnit"), "units"),
    prop("kilogramsPerUnit missing", lambda s: s.ClearMetadata("kilogramsPerUnit"), "units"),
    cabinet("upAxis missing", lambda s: s.ClearMetadata("upAxis"), "units"),
    prop("stage in centimetres", lambda s: UsdGeom.SetStageMetersPerUnit(s, 0.01), "units"),
    cabinet("stage in grams", lambda s: UsdPhysics.SetStageKilogramsPerUnit(s, 0.001), "units"),
    prop("y up", lambda s: UsdGeom.SetStageUpAxis(s, "Y"), "units"),
    prop("no default prim", lambda s: s.ClearDefaultPrim(), "default-prim"),
    cabinet("default prim that is not there", lambda s: s.SetMetadata("defaultPrim", "wardrobe"), "default-prim"),
    prop("a second root prim", lambda s: s.DefinePrim("/Other", "Xform"), "default-prim"),
    cabinet("kind group", lambda s: Usd.ModelAPI(s.GetDefaultPrim()).SetKind("group"), "default-prim"),
    prop("texture file gone", _picture("./nowhere.png"), "missing-file"),
    cabinet(
        "reference to nothing",
        on_prim(CABINET, lambda p: p.GetReferences().AddReference("./gone.usda")),
        "missing-file",
    ),
    prop("texture by absolute path", _picture("/tmp/picture.png"), "outside-file"),
    prop("texture by address", _picture("https://example.org/picture.png"), "outside-file"),
    prop(
        "a physics scene without gravity",
        lambda s: UsdPhysics.Scene.Define(s, f"{PROP}/Scene").CreateGravityMagnitudeAttr(0.0),
        "physics-scene",
    ),
    cabinet(
        "gravity upwards",
        lambda s: UsdPhysics.Scene.Define(s, f"{CABINET}/Scene").CreateGravityDirectionAttr(Gf.Vec3f(0, 0, 1)),
        "physics-scene",
    ),
    prop("mass over time", on_prim(PROP, lambda p: p.GetAttribute("physics:mass").Set(9.0, 5.0)), "time-samples"),
    cabinet(
        "moving by itself",
        on_prim(f"{CABINET}/door", lambda p: p.GetAttribute("xformOp:translate").Set(Gf.Vec3d(1), 5.0)),
        "time-samples",
    ),
    prop("purpose that nobody knows", put(f"{PROP}/Colliders/collider_01", "purpose", "physics"), "unknown-token"),
    cabinet(
        "subdivision that nobody knows",
        put(f"{CABINET}/door/Visuals/panel", "subdivisionScheme", "smooth"),
        "unknown-token",
    ),
    prop("metadata state another size", metadata("asset_extents", Gf.Vec3f(1, 1, 1)), "extent"),
    prop("metadata state a size in mm", metadata("asset_extents", Gf.Vec3f(100, 80, 60)), "extent"),
    prop("a wardrobe of 10 cm", both(label("class", "wardrobe"), metadata("category", "wardrobe")), "category-size"),
    cabinet("a mug of 80 cm", both(label("class", "mug"), metadata("category", "mug")), "category-size"),
    prop("asset lifted by 10 cm", place(PROP, (0, 0, 0.1)), "origin"),
    cabinet("asset lying on its side", place(CABINET, rotate=(90, 0, 0)), "origin"),
    prop("visible mesh off its origin", place(f"{PROP}/Visuals", (0.02, 0, 0)), "origin"),
    prop("wrong label", label("class", "chair"), "label"),
    cabinet("empty label", label("class"), "label"),
    prop("label of spaces", label("class", " "), "label"),
    cabinet("class label removed", unapply(CABINET, UsdSemantics.LabelsAPI, "class"), "label"),
    prop("another Q-code", label("wikidata_qcode", "Q1"), "label"),
    prop("Q-code of words", label("wikidata_qcode", "box"), "label"),
    cabinet("metadata name another category", metadata("category", "chair"), "label"),
    prop(
        "colliders 1 mm aside after release",
        after_release(lambda s, _: place(f"{PROP}/Colliders", (0.001, 0, 0))(s)),
        "record-file",
    ),
    prop(
        "thumbnail removed after release",
        after_release(lambda _, package: next(package.rglob(".thumbs/*/*.png")).unlink()),
        "record-file",
    ),
    prop(
        "URDF twin of something else",
        after_release(lambda _, package: next(package.glob("export/*.urdf")).write_text("<robot/>x")),
        "twin",
    ),
    cabinet("metadata state another mass", metadata("mass", 1.0), "metadata"),
    cabinet("metadata count two bodies", metadata("rigid_body_count", 2), "metadata"),
)

SOUND: tuple[Sound, ...] = (Sound("another author", "prop", metadata("author", "Ada Lovelace")),)
