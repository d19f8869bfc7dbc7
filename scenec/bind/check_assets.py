"""Checks every asset that a program names, once: it exists, it is usable, it can play its role."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_args

from scenec.bind.asset_library import AssetLibrary
from scenec.ir.single_assets import single_assets
from scenec.source.listing import written_assets
from schemas.asset import Role
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.scene.program import Asset, FixedAsset, PoolAsset, SceneProgram
from source.hint import did_you_mean
from source.tree import Path, Spans

ROLES: tuple[str, ...] = get_args(Role)


def check_assets(program: SceneProgram, library: AssetLibrary, spans: Spans) -> tuple[Diagnostic, ...]:
    """Findings about assets and roles, each where the asset is named."""
    diagnostics: dict[tuple[str, Path], Diagnostic] = {}
    for path, asset, scale, role, _ in written_assets(program):
        for at, diagnostic in _check(path, asset, scale, role, library):
            diagnostics.setdefault((diagnostic.code, at), diagnostic.model_copy(update={"where": spans.place(at)}))
    return (*_roles(program, spans), *diagnostics.values())


def _roles(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    for i, thing in enumerate(program.objects):
        if thing.role is not None and thing.role not in ROLES:
            headline = f"there is no role `{thing.role}`{did_you_mean(thing.role, ROLES)}"
            where = spans.place(("objects", i, "role"))
            yield finding("scene/unknown-name", headline, where=where, bound=", ".join(ROLES))


def _check(
    path: Path, asset: Asset | str, scale: float, role: str | None, library: AssetLibrary
) -> Iterator[tuple[Path, Diagnostic]]:
    places: dict[str, Path] = {}
    if isinstance(asset, PoolAsset):
        for k, candidates in enumerate(asset.candidates):
            for n, name in enumerate(candidates.assets):
                places.setdefault(name, (*path, "candidates", k, "assets", n))
    for single in single_assets(asset):
        at = (*path, "id") if isinstance(asset, FixedAsset) else path
        at = places.get(single.id, at) if isinstance(single, FixedAsset) else at
        try:
            geometry = library.geometry(single, scale)
        except InvalidInput as error:
            yield at, error.diagnostic
            continue
        roles = geometry.roles
        if geometry.doubts is not None:
            headline = f"the package `{geometry.asset_id}` waits for review"
            yield at, finding("scene/asset-in-review", headline, value=", ".join(geometry.doubts) or None)
        # An asset without known roles is accepted.
        if places and role in ROLES and roles and role not in roles:
            headline = f"`{geometry.asset_id}` is no {role}, but {', '.join(sorted(roles))}"
            yield at, finding("scene/role-mismatch", headline, value=", ".join(sorted(roles)), bound=role)
