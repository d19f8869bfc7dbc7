"""Checks on a source asset: its file is readable, its model has a usable surface, and how many objects it holds."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from assetkit.sources.discover import SourceAsset
from assetkit.sources.source_file import refusal
from geom.mesh.topology import is_all_degenerate, is_triangle_soup, observe
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.model import Model

MAX_FILE_BYTES = 2**30
# Descriptions of links and joints that a tool of their own turns into one that Mana reads.
TO_CONVERT = {
    ".xacro": ("robot/xacro", "the file is a xacro template"),
    ".sdf": ("robot/sdf", "SDF models are not read"),
}

LARGEST_COORDINATE = 1e100  # its cube, a volume, is still a number


def file_findings(asset: SourceAsset, formats: Collection[str]) -> list[Diagnostic]:
    """Why the file of `asset` cannot be read as one of `formats`, the first reason only; [] when it can."""
    source = asset.file
    if (unusable := refusal(source)) is not None:
        return [unusable]
    if not source.path.resolve().is_relative_to(source.root.resolve()):
        headline = "the file itself lies outside its root, perhaps through a link"
        return [finding("asset/path-escape", headline, bound="root")]
    suffix = source.path.suffix.lower()
    size = source.path.stat().st_size
    if suffix in TO_CONVERT:
        code, headline = TO_CONVERT[suffix]
        return [finding(code, headline, where=Location(file=source.relative), value=suffix)]
    if asset.format not in formats:
        headline = f"'{suffix or source.path.name}' is not a supported file type"
        return [finding("asset/format-unsupported", headline, value=suffix, bound=", ".join(sorted(formats)))]
    if size > MAX_FILE_BYTES:
        headline = "the file is too large"
        return [finding("asset/resource-limit", headline, value=size, bound=MAX_FILE_BYTES, unit="bytes")]
    return []


def require_surface(model: Model) -> None:
    """Raises InvalidInput when `model` has no faces, points that are not finite, no area, or only loose triangles."""
    if not model.meshes:
        raise InvalidInput(finding("asset/empty-geometry", "the file holds no triangles"))
    points = np.concatenate([m.points for m in model.meshes])
    if not np.isfinite(points).all():
        raise InvalidInput(finding("asset/nonfinite-vertices", "a coordinate is NaN or infinite after transforms"))
    largest = float(np.abs(points).max(initial=0.0))
    if largest > LARGEST_COORDINATE:
        headline = "a coordinate is so large that areas and volumes would be infinite"
        raise InvalidInput(
            finding("asset/nonfinite-vertices", headline, value=largest, bound=LARGEST_COORDINATE, unit="source units")
        )
    starts = np.cumsum([0, *(len(m.points) for m in model.meshes)])[:-1]
    triangles = np.concatenate([m.triangles + s for m, s in zip(model.meshes, starts, strict=True)])
    topology = observe(points, triangles, "merged")
    if is_all_degenerate(topology):
        raise InvalidInput(
            finding("asset/degenerate-geometry", "every face has zero area", value=topology.degenerate_faces, bound=0)
        )
    if is_triangle_soup(topology):
        raise InvalidInput(
            finding(
                "asset/triangle-soup",
                f"{topology.triangles} triangles form {topology.components} unconnected pieces",
                value=topology.components,
                unit="pieces",
            )
        )


def several_objects(count: int, limit: int, *, too_many: bool) -> Diagnostic:
    """The finding that a file holds `count` objects; a warning when they are more than `limit` (`too_many`)."""
    return finding(
        "asset/several-objects",
        f"the file holds {count} separate objects"
        + ("; a person must say which belong together" if too_many else "; each becomes a package of its own"),
        value=count,
        bound=limit,
        unit="objects",
        severity=Severity.WARNING if too_many else Severity.INFO,
    )
