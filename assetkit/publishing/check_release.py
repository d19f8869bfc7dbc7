"""Compares the files of a release folder with its manifest."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from assetkit.publishing.release_folder import MANIFEST, MANIFEST_VERSION
from jobs.cache import changed_files
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding


class ReleaseManifest(BaseModel):
    """What of `manifest.json` is compared: its version, and the SHA-256 of each file by its path."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    manifest_version: int
    files: dict[str, str]


def check_release(folder: Path) -> tuple[int, tuple[Diagnostic, ...]]:
    """The number of files in the manifest of a release, and a finding for each that was changed, lost or added.

    Raises InvalidInput `asset/release-unreadable` for a folder without a manifest of a known version.
    """
    try:
        manifest = ReleaseManifest.model_validate_json((folder / MANIFEST).read_bytes())
    except (OSError, ValidationError) as error:
        raise _unreadable("it is absent" if isinstance(error, OSError) else "it is no manifest") from error
    if manifest.manifest_version != MANIFEST_VERSION:
        raise _unreadable(f"its version is {manifest.manifest_version}")
    return len(manifest.files), tuple(_differences(folder, manifest))


def _differences(folder: Path, manifest: ReleaseManifest) -> Iterator[Diagnostic]:
    changed = changed_files(folder, manifest.files)
    for name in changed:
        state = "changed" if (folder / name).is_file() else "absent"
        yield finding("asset/release-altered", f"'{name}' is {state}", where=Location(file=name))
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if (path.is_symlink() or path.is_file()) and name not in manifest.files and name != MANIFEST:
            yield finding("asset/release-altered", f"'{name}' is not in the manifest", where=Location(file=name))


def _unreadable(why: str) -> InvalidInput:
    headline = f"{MANIFEST} cannot be read: {why}"
    return InvalidInput(finding("asset/release-unreadable", headline, where=Location(file=MANIFEST)))
