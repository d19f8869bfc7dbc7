"""The environment that holds Blender (`bpy`): where it is, whether it is complete, and how it is made.

Blender is a program of its own under the GPL, 370 MB to download and 970 MB installed, and needs another NumPy than
Mana; so it lives apart, is called as a child process, and is made when the user wants it.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

REQUIREMENTS = Path(__file__).with_name("requirements.txt")
VARIABLE = "MANA_BLENDER"  # an environment variable with another folder than the usual one
STAMP = "mana-installed"
_PROBE_S = 120.0


class InstallationFailed(Exception):
    """Blender could not be installed; the text holds the last lines of what went wrong."""


def folder() -> Path:
    """Where the environment is, or would be: `MANA_BLENDER`, else below the user's data folder (XDG)."""
    if named := os.environ.get(VARIABLE):
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(data) / "mana" / "blender"


def python() -> Path | None:
    """The Python of a complete environment with the versions that this Mana wants, None where there is none."""
    program, stamp = folder() / "bin" / "python", folder() / STAMP
    try:
        return program if program.exists() and stamp.read_text() == wanted_versions() else None
    except OSError:
        return None


def install() -> None:
    """Make the environment, or complete what an interrupted run left. Raises InstallationFailed.

    Packages come from the package index that pip is configured for; what it has downloaded already it takes from its
    own cache. The stamp is written last, after Blender has started once.
    """
    if python() is not None:
        return
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
        (place / STAMP).unlink(missing_ok=True)
    except OSError as error:
        raise InstallationFailed(f"cannot write into '{place}': {error.strerror}") from error
    program = place / "bin" / "python"
    if not program.exists():
        _run([sys.executable, "-m", "venv", str(place)])
    _run([str(program), "-m", "pip", "install", "--disable-pip-version-check", "-r", str(REQUIREMENTS)])
    _run([str(program), "-c", "import bpy"], seconds=_PROBE_S)
    (place / STAMP).write_text(wanted_versions())


def wanted_versions() -> str:
    """A hash of the packages and versions that this Mana wants."""
    return hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()


def _run(argv: list[str], seconds: float | None = None) -> None:
    try:
        done = subprocess.run(argv, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        raise InstallationFailed(f"`{' '.join(argv)}` took longer than {seconds:g} s") from None
    if done.returncode != 0:
        lines = (done.stdout + done.stderr).strip().splitlines()[-5:]
        raise InstallationFailed("\n".join([f"`{' '.join(argv[:4])} ...` failed:", *lines]))
