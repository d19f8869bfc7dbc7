"""Checks a USDZ package before OpenUSD opens it (USDZ specification, 1.3: an uncompressed, unencrypted ZIP)."""

from __future__ import annotations

import zipfile
from pathlib import Path, PurePosixPath
from typing import Final

from schemas.diagnostics import InvalidInput, Location, finding
from schemas.files.zip_damage import ZIP_DAMAGE

MAX_BYTES: Final = 2**30
MAX_ENTRIES: Final = 65536
LAYER_SUFFIXES: Final = (".usda", ".usdc", ".usd")
_ENCRYPTED: Final = 0x1


def check_package(path: Path, *, where: Location) -> str:
    """The name of the package's root layer: its first entry that is a USD layer. Nothing is extracted.

    Raises InvalidInput: `asset/path-escape` for an entry that is absolute or climbs out, `asset/resource-limit` for
    compressed or encrypted entries, more than 65,536 entries or 1 GiB unpacked, `asset/truncated` when the archive is
    cut off, `asset/wrong-content` when it is no archive or holds no USD layer.
    """
    if not zipfile.is_zipfile(path):
        raise InvalidInput(_no_archive(path, where))
    try:
        with zipfile.ZipFile(path) as package:
            entries = package.infolist()
            _check_entries(entries, where)
            # This also compares the local headers, which OpenUSD goes by, with the directory checked above.
            damaged = package.testzip()
            if damaged is not None:
                raise zipfile.BadZipFile(f"'{damaged}' does not match its checksum")
    except ZIP_DAMAGE as error:
        raise InvalidInput(finding("asset/truncated", f"the package is damaged: {error}", where=where)) from error
    layers = [e.filename for e in entries if e.filename.lower().endswith(LAYER_SUFFIXES)]
    if not layers:
        raise InvalidInput(finding("asset/wrong-content", "the package holds no USD layer", where=where))
    return layers[0]


def _no_archive(path: Path, where: Location):
    with path.open("rb") as file:
        starts_as_zip = file.read(4) == b"PK\x03\x04"
    if starts_as_zip:
        return finding("asset/truncated", "the package ends before its directory", where=where)
    return finding("asset/wrong-content", "the file is named .usdz but is no ZIP archive", where=where)


def _check_entries(entries: list[zipfile.ZipInfo], where: Location) -> None:
    if len(entries) > MAX_ENTRIES:
        raise InvalidInput(
            finding(
                "asset/resource-limit",
                f"the package has {len(entries)} entries",
                where=where,
                value=len(entries),
                bound=MAX_ENTRIES,
                unit="entries",
            )
        )
    for entry in entries:
        name = entry.filename.replace("\\", "/")
        if PurePosixPath(name).is_absolute() or ".." in name.split("/") or name[1:3] == ":/":
            raise InvalidInput(
                finding("asset/path-escape", f"entry '{entry.filename}' leads out of the package", where=where)
            )
    for entry in entries:
        if entry.compress_type != zipfile.ZIP_STORED or entry.flag_bits & _ENCRYPTED:
            how = "encrypted" if entry.flag_bits & _ENCRYPTED else "compressed"
            raise InvalidInput(
                finding(
                    "asset/resource-limit",
                    f"entry '{entry.filename}' is {how}, which USDZ forbids; it is not unpacked",
                    where=where,
                    value=entry.file_size,
                    bound=entry.compress_size,
                    unit="bytes",
                )
            )
    total = sum(entry.file_size for entry in entries)
    if total > MAX_BYTES:
        raise InvalidInput(
            finding(
                "asset/resource-limit",
                "the package unpacks to more than 1 GiB",
                where=where,
                value=total,
                bound=MAX_BYTES,
                unit="bytes",
            )
        )
