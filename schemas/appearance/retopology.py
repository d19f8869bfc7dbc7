"""What a record holds on retopology: the light mesh, its atlas, and how far it departs from the source surface."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from schemas.evidence import Evidence

MapUnit = Literal["of 255", "degrees"]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class ViewFidelity(_Section):
    """One view: silhouettes of source and result as intersection over union, the mean difference of lit colours."""

    silhouette_iou: float
    colour_error_255: float


class MapError(_Section):
    """How far a baked map departs from the source, at points spread evenly by area over the source surface."""

    mean: Evidence[float]
    p95: float
    unit: MapUnit


class RetopologySection(_Section):
    """A light mesh in place of the source's, or the try of one that was dropped (`released` is then False).

    `meshes` are the ids of those with new triangles, `kept` of those that stay as they are because their material needs
    its own coordinates. `texels_by_ray` is the share of texels whose place on the source a ray found, `atlas_used` the
    share of the picture that charts cover. `silhouette_iou` is the least of all views, `colour_error_255` the largest.
    """

    released: bool
    method: str
    triangles_before: int
    triangles_after: int
    texture_px: int
    atlas_used: float
    texels_by_ray: float
    meshes: tuple[str, ...]
    kept: tuple[str, ...] = ()
    silhouette_iou: Evidence[float]
    colour_error_255: Evidence[float]
    views: dict[str, ViewFidelity]
    maps: dict[str, MapError]
