"""Versions of the libraries and a hash of the code whose results are stored: part of every cache key."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from pathlib import Path

from jobs.cache import content_key, file_sha256

_PACKAGES = ("assetkit", "formats", "geom", "gate", "scene_check", "jobs", "render", "schemas", "sim", "usdio")

_LIBRARIES = (
    "coacd",
    "fast-simplification",
    "manifold3d",
    "mana-sim",
    "numpy",
    "open3d",
    "pybullet",
    "pymeshlab",
    "scipy",
    "simready-validate",
    "trimesh",
    "usd-core",
    "vhacdx",
    "vtk",
    "xatlas",
)


@cache
def library_versions() -> dict[str, str]:
    """Installed version by distribution name, and a hash of Mana's own code under `code`."""
    return {name: version(name) for name in _LIBRARIES} | {"code": code_hash(_PACKAGES)}


@cache
def versions_key() -> str:
    """One key over `library_versions`: what is stored under another one is never read by this installation."""
    return content_key(library_versions())


def code_hash(packages: tuple[str, ...]) -> str:
    """One hash over the Python files of packages of Mana: an editable installation changes without a new version."""
    home = Path(__file__).parents[1]
    files = sorted(f for package in packages for f in (home / package).rglob("*.py"))
    return content_key([(f.relative_to(home).as_posix(), file_sha256(f)) for f in files])
