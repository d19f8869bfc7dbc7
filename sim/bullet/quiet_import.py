"""Imports pybullet without the line about its build that the module writes to the standard error of the process.

The line comes from C, below `sys.stderr`: file descriptor 2 leads to a file during the import; the rest is passed on.
"""

from __future__ import annotations

import os
import sys
import tempfile
from importlib import import_module

_BUILD_LINE = b"pybullet build time"
_STDERR = 2  # file descriptor


def import_pybullet() -> None:
    """Import the module; whatever else the import writes to standard error still gets there."""
    if "pybullet" in sys.modules:
        return
    try:
        terminal = os.dup(_STDERR)
    except OSError:  # The process has no standard error.
        import_module("pybullet")
        return
    with tempfile.TemporaryFile() as written:
        os.dup2(written.fileno(), _STDERR)
        try:
            import_module("pybullet")
        finally:
            os.dup2(terminal, _STDERR)
            os.close(terminal)
            written.seek(0)
            rest = b"".join(line for line in written if not line.startswith(_BUILD_LINE))
            if rest:
                os.write(_STDERR, rest)
