"""Parts: labelled regions of an object's visible surface, in the frame of their asset (metres)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from schemas.arrays import IntArray
from schemas.evidence import Evidence, default

UNLABELLED = "unlabelled"
Point3 = tuple[float, float, float]
# Who proposed a region: nodes of the source, its render materials, connected surfaces, the shape, a learned segmenter.
ProposalSource = Literal["hierarchy", "material", "component", "shape", "learned"]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class PartFaces(_Model):
    """Triangles of one visual mesh. `mesh` is its id, which its prim below `Visuals` has as its name.

    `ranges` lists indices and inclusive runs, rising: `0-11 15 20-33`. The mesh's triangles are counted as it was
    handed to the USD writer; `UsdGeom.Subset` of the part's name follows where the writer had to list them otherwise.
    """

    mesh: str
    ranges: str

    @property
    def indices(self) -> IntArray:
        """(k,) the triangles, rising."""
        runs = [run.partition("-") for run in self.ranges.split()]
        spans = [np.arange(int(first), int(last or first) + 1) for first, _, last in runs]
        return np.concatenate(spans) if spans else np.zeros(0, dtype=np.int64)


def part_faces(mesh: str, indices: Sequence[int] | IntArray) -> PartFaces:
    """The triangles `indices` (k,) of `mesh`, in any order."""
    numbers = np.unique(np.asarray(indices, dtype=np.int64))
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1) if len(numbers) else []
    texts = (f"{run[0]}" if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)
    return PartFaces(mesh=mesh, ranges=" ".join(texts))


class Part(_Model):
    """One part. Its evidence gives the confidence that the region is a part at all.

    `part_id` numbers the parts of an asset, the one with most surface first, whatever they are called. `label` is a
    part name of the asset's category, or `unlabelled` with confidence 0; equal parts share it (four times `leg`).
    `parent` is the part whose region or box holds this one.
    """

    part_id: str
    label: Evidence[str]
    may_be: tuple[str, ...] = Field(default=(), description="labels that clues speak for which contradict each other")
    material: Evidence[str] = Field(default=default("unknown"), description="class in the material table")
    name: str = Field(description="the label, else what the source calls it, else the id")
    sources: tuple[ProposalSource, ...] = Field(description="all that proposed about this region")
    source_path: str = Field(default="", description="of its node, where a node is the part")
    faces: tuple[PartFaces, ...]
    triangles: int
    area_m2: float
    low_m: Point3
    high_m: Point3
    parent: str | None = None
    link: str | None = Field(
        default=None, exclude_if=lambda link: link is None, description="of an articulated object, if it is on one only"
    )

    def mask(self, mesh: str, count: int) -> IntArray:
        """(count,) True at the triangles of `mesh` that belong to it."""
        result = np.zeros(count, dtype=bool)
        for faces in self.faces:
            if faces.mesh == mesh:
                result[faces.indices] = True
        return result


def labelled(parts: Sequence[Evidence[Part]], label: str) -> tuple[Evidence[Part], ...]:
    """The parts called `label`, the surest label first."""
    matching = (p for p in parts if p.value.label.value == label)
    return tuple(sorted(matching, key=lambda p: (-p.value.label.confidence, p.value.part_id)))


def by_id(parts: Sequence[Evidence[Part]]) -> Mapping[str, Part]:
    """Part id -> part."""
    return {p.value.part_id: p.value for p in parts}
