"""Rule: a joint frame lies near both of its bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import diagonal, stacked
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-anchor",
    "A hinge lies far away from its bodies",
    "The link would swing round a point in the air.",
    "check localPos0 and localPos1: they are in the frames of the bodies",
)
ANCHOR_BODY_SIZES, ANCHOR_ASSET_SIZES = 1.0, 0.5  # of the body, of the whole asset


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per hinge or ball joint that lies further from a body than the body is large."""
    asset_m = diagonal(stacked([cloud for b in subject.bodies for cloud in (b.collider_points_W, b.visible_points_W)]))
    for joint in subject.joints:
        if joint.kind not in ("revolute", "spherical"):
            continue
        for side in joint.sides:
            body = side.body
            if body is None or body.diagonal_m == 0.0 or not np.all(np.isfinite(side.X_WJ)):
                continue
            away_m = _distance(side.X_WJ[:3, 3], body)
            bound_m = max(ANCHOR_BODY_SIZES * body.diagonal_m, ANCHOR_ASSET_SIZES * asset_m)
            if away_m > bound_m:
                yield finding(
                    CODE,
                    f"the joint lies far away from {body.path}",
                    where=at(joint.prim),
                    value=away_m,
                    bound=bound_m,
                    unit="m",
                    severity=Severity.WARNING,
                )


def _distance(point_W: np.ndarray, body: Body) -> float:
    """From the point to the body's bounding box."""
    cloud = stacked([body.collider_points_W, body.visible_points_W])
    outside = np.maximum(0.0, np.maximum(cloud.min(axis=0) - point_W, point_W - cloud.max(axis=0)))
    return float(np.linalg.norm(outside))


RULE = Rule(
    CODE, "within one diagonal of each body, or half that of the asset", "hinges are part of what they join", check
)
