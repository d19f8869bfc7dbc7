"""Reads the record of a package folder; a folder without a valid one is no package of Mana."""

from __future__ import annotations

from pathlib import Path

from schemas.asset import RECORD, AssetRecord


def read_record(package: Path) -> AssetRecord | None:
    """The record of a package folder, None when the folder is no package of that name."""
    try:
        record = AssetRecord.model_validate_json((package / RECORD).read_bytes())
    except (OSError, ValueError):
        return None
    return record if record.asset_id == package.name else None
