"""Single assets: the fixed or inline assets that one authored asset of a program may stand for."""

from __future__ import annotations

from schemas.scene.program import Asset, FixedAsset, Inline, PoolAsset

SingleAsset = Inline | FixedAsset  # an asset that is no pool


def single_assets(asset: Asset | str) -> tuple[SingleAsset, ...]:
    """The candidates of an authored asset, each once, in the order of the program; one for an asset that is no pool."""
    if isinstance(asset, str):
        return (FixedAsset(type="fixed", id=asset),)
    if isinstance(asset, PoolAsset):
        ids = dict.fromkeys(asset_id for candidates in asset.candidates for asset_id in candidates.assets)
        return tuple(FixedAsset(type="fixed", id=asset_id) for asset_id in ids)
    return (asset,)
