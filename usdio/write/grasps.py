"""Authors grasps in SimReady's convention: an Xform `grasp_identifier_NN` with a line of two points (GSP.001).

SimReady's benchmark requires the Xform and `points` of a child; its static rule requires that child to be BasisCurves.
MuJoCo rejects files with curves, so a variant set decides: `grasp_lines` is `points` unless `curves` is selected.
"""

from __future__ import annotations

from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom

from schemas.package import GraspLines

WIDTH_M = 0.001
VARIANT_SET, POINTS, CURVES = "grasp_lines", "points", "curves"


def author_grasps(stage: Usd.Stage, root: Sdf.Path, lines_m: GraspLines) -> None:
    """Define `<root>/grasp_identifier_NN/grasp_identifier_NN_line` for the two ends of each line, asset frame.

    Their purpose is guide, so they are not rendered. Without a grasp there is no variant set.
    """
    if not lines_m:
        return
    choice = stage.GetPrimAtPath(root).GetVariantSets().AddVariantSet(VARIANT_SET)
    frames = [root.AppendChild(f"grasp_identifier_{index:02d}") for index in range(1, len(lines_m) + 1)]
    for frame in frames:
        xform = UsdGeom.Xform.Define(stage, frame)
        UsdGeom.Imageable(xform).CreatePurposeAttr(UsdGeom.Tokens.guide)
    for variant, author in ((CURVES, _curve), (POINTS, _points)):
        choice.AddVariant(variant)
        choice.SetVariantSelection(variant)
        with choice.GetVariantEditContext():
            for frame, ends in zip(frames, lines_m, strict=True):
                author(stage, frame.AppendChild(f"{frame.name}_line"), [Gf.Vec3f(*end) for end in ends])


def add_grasps(main_file: Path, lines_m: GraspLines) -> Path:
    """Author grasps into a package that `write_package` wrote without any; returns the one file that changes.

    The bytes are those that `write_package` gives for the content with these grasps. Raises OSError when writing fails.
    """
    physics_file = main_file.parent / "payloads" / f"{main_file.stem}_physics.usda"
    layer = Sdf.Layer.OpenAsAnonymous(str(physics_file))
    author_grasps(Usd.Stage.Open(layer), Sdf.Path.absoluteRootPath.AppendChild(layer.defaultPrim), lines_m)
    if not layer.Export(str(physics_file)):
        raise OSError(f"USD could not write {physics_file.name}")
    return physics_file


def _points(stage: Usd.Stage, path: Sdf.Path, ends: list[Gf.Vec3f]) -> None:
    scope = UsdGeom.Scope.Define(stage, path).GetPrim()
    scope.CreateAttribute("points", Sdf.ValueTypeNames.Point3fArray, custom=True).Set(ends)


def _curve(stage: Usd.Stage, path: Sdf.Path, ends: list[Gf.Vec3f]) -> None:
    curve = UsdGeom.BasisCurves.Define(stage, path)
    curve.CreateTypeAttr(UsdGeom.Tokens.linear)
    curve.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    curve.CreatePointsAttr(ends)
    curve.CreateCurveVertexCountsAttr([2])
    curve.CreateWidthsAttr([WIDTH_M])
    curve.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    curve.CreateExtentAttr(UsdGeom.Curves(curve).ComputeExtent(ends, [WIDTH_M]))
