"""Author grasps as SimReady reads them: an Xform `grasp_identifier_NN` with a line of two points (GSP.001)."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Sdf, Usd, UsdGeom

from schemas.anchors import Point3

WIDTH_M = 0.001


def author_grasps(stage: Usd.Stage, root: Sdf.Path, lines_m: Sequence[tuple[Point3, Point3]]) -> None:
    """Define `<root>/grasp_identifier_NN/grasp_identifier_NN_line` for the two ends of each line, asset frame.

    The static rule wants the curves, the benchmark the Xform around them. Their purpose is guide: they are no look.
    """
    for index, ends in enumerate(lines_m, start=1):
        name = f"grasp_identifier_{index:02d}"
        xform = UsdGeom.Xform.Define(stage, root.AppendChild(name))
        UsdGeom.Imageable(xform).CreatePurposeAttr(UsdGeom.Tokens.guide)
        curve = UsdGeom.BasisCurves.Define(stage, xform.GetPath().AppendChild(f"{name}_line"))
        curve.CreateTypeAttr(UsdGeom.Tokens.linear)
        curve.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
        points = [Gf.Vec3f(*end) for end in ends]
        curve.CreatePointsAttr(points)
        curve.CreateCurveVertexCountsAttr([2])
        curve.CreateWidthsAttr([WIDTH_M])
        curve.SetWidthsInterpolation(UsdGeom.Tokens.constant)
        curve.CreateExtentAttr(UsdGeom.Curves(curve).ComputeExtent(points, [WIDTH_M]))
