"""Whether this system lets a process leave the network, by the program `unshare` of util-linux."""

from __future__ import annotations

import subprocess
from functools import cache


@cache
def network_may_be_left() -> bool:
    """Whether a network namespace may be made, alone or within a user namespace."""
    ways = (["unshare", "--net", "true"], ["unshare", "--user", "--net", "true"])
    return any(subprocess.run(way, capture_output=True, check=False).returncode == 0 for way in ways)
