"""Whether the files of a package are those that were tried in simulation."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path


def changed_files(package: Path, hashes: Mapping[str, str]) -> list[str]:
    """Files of shape and physics that are absent or other than recorded, in the order of their names.

    `hashes` are those of `record.json`. Stable poses, anchors and grasps are not of such a package. Looks may change.
    """
    kept = [name for name in sorted(hashes) if name.startswith("usd/") and "_materials." not in name]
    return [name for name in kept if not (package / name).is_file() or _sha256(package / name) != hashes[name]]


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
