"""Paths, in the program, of the variants and candidates that a combination chooses."""

from __future__ import annotations

from collections.abc import Mapping

from scenec.bind.variants import AS_WRITTEN, ASSETS, BACKGROUND_POOL, BACKGROUNDS, slot_key
from schemas.scene.program import Asset, PoolAsset, SceneProgram
from source.tree import Path


def chosen_paths(program: SceneProgram, combination: Mapping[str, str]) -> dict[str, Path]:
    """Path of the chosen value by key; values as authored, without variants, have none."""
    variants = program.variants
    background = program.background.asset if program.background is not None else None
    paths: dict[str, Path] = {}
    for key, value in combination.items():
        if value == AS_WRITTEN:
            continue
        path: Path | None = None
        if key == ASSETS:
            path = ("variants", "assets", [variant.id for variant in variants.assets].index(value))
        elif key == BACKGROUNDS:
            path = ("variants", "backgrounds", [variant.id for variant in variants.backgrounds].index(value))
        elif key in [slot_key(variant.group) for variant in variants.slots]:
            keys = [(slot_key(variant.group), variant.id) for variant in variants.slots]
            path = ("variants", "slots", keys.index((key, value)))
        elif key == BACKGROUND_POOL:
            path = _candidate(background, value, ("background", "asset"))
        else:
            path = candidate_path(program, key.removeprefix("objects."), value, combination.get(ASSETS, AS_WRITTEN))
        if path is not None:
            paths[key] = path
    return paths


def candidate_path(program: SceneProgram, name: str, asset: str, variant: str = AS_WRITTEN) -> Path | None:
    """Path of an asset id among the candidates of an object under an asset variant; None where it is no candidate."""
    for i, changed in enumerate(program.variants.assets):
        if changed.id == variant and name in changed.objects:
            return _candidate(changed.objects[name], asset, ("variants", "assets", i, "objects", name))
    number = [one.id for one in program.objects].index(name)
    return _candidate(program.objects[number].asset, asset, ("objects", number, "asset"))


def _candidate(asset: Asset | str | None, name: str, path: Path) -> Path | None:
    if isinstance(asset, PoolAsset):
        for k, candidates in enumerate(asset.candidates):
            if name in candidates.assets:
                return (*path, "candidates", k, "assets", candidates.assets.index(name))
    return None
