"""Packages with USD, twins and a valid record, made in a moment: what commands on libraries need, without a batch."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from assetkit.package.package import Package
from assetkit.package.record import RECORD
from assetkit.package.write_twins import write_twins
from schemas.package import PackageContent
from usdio.reread.body import reread_package
from usdio.write.package import write_package

RECORD_SAMPLE = Path(__file__).parents[2] / "data" / "record.json"


def packaged(out: Path, content: PackageContent, source: Mapping[str, Any] | None = None, **fields: Any) -> Path:
    """The package of `content` below `out`; its record is the sample's, with these values of `source` and fields."""
    folder = out / content.asset_id
    write_twins(reread_package(write_package(content, folder)), content, folder)
    return recorded(folder, source, **fields)


def recorded(folder: Path, source: Mapping[str, Any] | None = None, **fields: Any) -> Path:
    """The folder with a record over the files that lie in it now."""
    record = json.loads(RECORD_SAMPLE.read_text())
    record["source"] |= source or {}
    (folder / RECORD).unlink(missing_ok=True)
    record |= {"asset_id": folder.name, "hashes": dict(Package.on_disk(folder).hashes)} | fields
    (folder / RECORD).write_text(json.dumps(record, indent=1))
    return folder


def stated(value: str) -> dict[str, Any]:
    """A licence or author that the source file declares, as records hold it."""
    return {"value": value, "source": "declared", "method": "source file", "confidence": 1.0}
