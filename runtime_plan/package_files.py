"""Whether the files of a package are those that were tried in simulation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from jobs.cache import changed_files


def changed_physics(package: Path, hashes: Mapping[str, str]) -> list[str]:
    """Files of shape and physics that are absent or other than recorded, in the order of their names.

    `hashes` are those of `record.json`. Stable poses, anchors and grasps are not of such a package. Looks may change.
    """
    physics_hashes = {
        name: hashes[name] for name in sorted(hashes) if name.startswith("usd/") and "_materials." not in name
    }
    return changed_files(package, physics_hashes)
