"""Finds the visible gprims of a stage, instances expanded, and the world transform of each (4x4, stage units)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Gf, Usd, UsdGeom

from schemas.diagnostics import InvalidInput, finding
from schemas.model import Node
from usdio.read.layer_guard import PinnedLayers
from usdio.read.meshes import EARLIEST, FACELESS, IMPLICIT_SHAPES, UNSUPPORTED

MAX_INSTANCES: Final = 1000
MAX_PRIMS: Final = 200_000
_DRAWN: Final = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


@dataclass(frozen=True)
class PlacedGprim:
    """A gprim and its pose: `X_WP` is 4x4, column convention, double. `copy` numbers point-instancer copies."""

    prim: Usd.Prim
    X_WP: np.ndarray
    purpose: str
    copy: int | None = None


@dataclass(frozen=True)
class StageGprims:
    """Everything found below a prim: surfaces to read, the hierarchy, and what cannot become a surface."""

    placed: tuple[PlacedGprim, ...]
    nodes: tuple[Node, ...]
    faceless: tuple[Usd.Prim, ...]
    animated: Usd.Prim | None


def find_gprims(start: Usd.Prim, layers: PinnedLayers) -> StageGprims:
    """The visible gprims at or below `start`, instances included, with double-precision world transforms.

    Guides and proxies are left out unless there is nothing else. Raises InvalidInput `asset/resource-limit` for more
    than 200,000 prims or 1,000 point-instancer copies.
    """
    traversal = _Traversal(layers)
    placed = tuple(traversal.below(start, None, 0))
    drawn = tuple(p for p in placed if p.purpose in _DRAWN)
    proxies = tuple(p for p in placed if p.purpose == UsdGeom.Tokens.proxy)
    return StageGprims(
        drawn or proxies or placed, tuple(traversal.nodes), tuple(traversal.faceless), traversal.animated
    )


def column_matrix(value: Gf.Matrix4d) -> np.ndarray:
    """A USD matrix (row vectors) as a (4, 4) array for column vectors."""
    return np.array(value, dtype=np.float64).T


class _Traversal:
    def __init__(self, layers: PinnedLayers) -> None:
        self._layers = layers
        self._poses = UsdGeom.XformCache(EARLIEST)
        self._prims = 0
        self._copies = 0
        self.nodes: list[Node] = []
        self.faceless: list[Usd.Prim] = []
        self.animated: Usd.Prim | None = None

    def below(self, start: Usd.Prim, X_WS: np.ndarray | None, depth: int) -> Iterator[PlacedGprim]:
        """Gprims below `start`; with `X_WS`, `start` is a prototype at that pose instead of its own."""
        prims = iter(Usd.PrimRange(start, Usd.TraverseInstanceProxies()))
        for prim in prims:
            self._count(prim)
            imageable = UsdGeom.Imageable(prim)
            if imageable and imageable.GetVisibilityAttr().Get(EARLIEST) == UsdGeom.Tokens.invisible:
                prims.PruneChildren()
                continue
            if self.animated is None and _is_animated(prim):
                self.animated = prim
            if X_WS is None and prim.IsA(UsdGeom.Xformable):
                local, _ = self._poses.GetLocalTransformation(prim)
                self.nodes.append(Node(str(prim.GetPath()), column_matrix(local)))
            kind = prim.GetTypeName()
            if kind == "PointInstancer":
                prims.PruneChildren()
                yield from self._instances(prim, self._pose(prim, start, X_WS), depth)
            elif kind == "Mesh" or kind in IMPLICIT_SHAPES:
                purpose = UsdGeom.Imageable(prim).ComputePurpose()
                yield PlacedGprim(prim, self._pose(prim, start, X_WS), purpose, None if X_WS is None else self._copies)
            elif kind in FACELESS or kind in UNSUPPORTED:
                self.faceless.append(prim)

    def _pose(self, prim: Usd.Prim, start: Usd.Prim, X_WS: np.ndarray | None) -> np.ndarray:
        if X_WS is None:
            return column_matrix(self._poses.GetLocalToWorldTransform(prim))
        relative, _ = self._poses.ComputeRelativeTransform(prim, start)
        return X_WS @ column_matrix(relative)

    def _instances(self, prim: Usd.Prim, X_WI: np.ndarray, depth: int) -> Iterator[PlacedGprim]:
        """The expanded copies of a point instancer; instancers within prototypes are expanded in turn."""
        instancer = UsdGeom.PointInstancer(prim)
        poses = instancer.ComputeInstanceTransformsAtTime(
            EARLIEST, EARLIEST, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.ApplyMask
        )
        chosen = list(instancer.GetProtoIndicesAttr().Get(EARLIEST) or [])
        mask = instancer.ComputeMaskAtTime(EARLIEST)
        if len(mask):
            chosen = [index for index, active in zip(chosen, mask, strict=True) if active]
        prototypes = [prim.GetStage().GetPrimAtPath(p) for p in instancer.GetPrototypesRel().GetForwardedTargets()]
        for index, pose in zip(chosen, poses, strict=False):
            if not 0 <= index < len(prototypes) or not prototypes[index] or depth > 8:
                raise InvalidInput(
                    finding(
                        "asset/index-out-of-range",
                        f"an instance refers to prototype {index} of {len(prototypes)}",
                        where=self._layers.location_of(self._layers.root).where(prim=str(prim.GetPath())),
                        value=index,
                        bound=len(prototypes) - 1,
                    )
                )
            self._copies += 1
            self._limit(self._copies, MAX_INSTANCES, "point-instancer copies", prim)
            yield from self.below(prototypes[index], X_WI @ column_matrix(pose), depth + 1)

    def _count(self, prim: Usd.Prim) -> None:
        self._prims += 1
        self._limit(self._prims, MAX_PRIMS, "prims", prim)

    def _limit(self, count: int, bound: int, unit: str, prim: Usd.Prim) -> None:
        if count > bound:
            where = self._layers.location_of(self._layers.root).where(prim=str(prim.GetPath()))
            headline = f"the stage expands to more than {bound} {unit}"
            raise InvalidInput(
                finding("asset/resource-limit", headline, where=where, value=count, bound=bound, unit=unit)
            )


def _is_animated(prim: Usd.Prim) -> bool:
    """True iff the prim's shape or transform has more than one time sample, or a skeleton drives it."""
    if prim.GetTypeName() == "Skeleton":
        return True
    names = [a for a in prim.GetAuthoredAttributes() if a.GetName().startswith(("xformOp:", "points", "visibility"))]
    return any(a.GetNumTimeSamples() > 1 for a in names)
