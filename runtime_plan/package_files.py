"""Compare the files of a package with the hashes in its record: shape and physics as tested in simulation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from jobs.cache import changed_files


def changed_physics(package: Path, hashes: Mapping[str, str]) -> list[str]:
    """Files of shape and physics that are absent or differ from their recorded hash, sorted by name.

    `hashes` are those of `record.json`. Stable poses, anchors and grasps of a changed package are invalid; its
    materials of appearance may change.
    """
    physics_hashes = {
        name: hashes[name] for name in sorted(hashes) if name.startswith("usd/") and "_materials." not in name
    }
    return changed_files(package, physics_hashes)
