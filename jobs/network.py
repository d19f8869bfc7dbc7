"""Takes the network away from a process: code that a hostile file takes over can neither fetch nor send.

    python -m jobs.network      # says whether this system allows it

A network namespace of its own (Linux, unshare(2)) has no interface but a loopback that is down. Root may make one,
others need a user namespace first, which some systems and containers forbid. Unix sockets by a path stay.
"""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

_CLONE_NEWUSER, _CLONE_NEWNET = 0x10000000, 0x40000000  # linux/sched.h
_PROCESS = Path("/proc/self")


def leave_network() -> bool:
    """Moves the calling thread, and what it starts from now on, into an empty network; False where that is forbidden.

    Call it in a process of one thread: user namespaces are for those alone.
    """
    if sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(_CLONE_NEWNET) == 0:
        return True
    user, group = os.getuid(), os.getgid()
    if libc.unshare(_CLONE_NEWUSER | _CLONE_NEWNET) != 0:
        return False
    # Files belong to the same numbers as before, so that nothing else changes.
    (_PROCESS / "setgroups").write_text("deny")
    (_PROCESS / "uid_map").write_text(f"{user} {user} 1")
    (_PROCESS / "gid_map").write_text(f"{group} {group} 1")
    return True


if __name__ == "__main__":
    left = leave_network()
    print("cells have no network" if left else "cells keep the network: namespaces are forbidden here")
    sys.exit(0 if left else 1)
