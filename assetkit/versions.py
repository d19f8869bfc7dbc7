"""The versions of the libraries whose results we cache: an upgrade rebuilds, nothing else does."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version

_LIBRARIES = (
    "coacd",
    "fast-simplification",
    "manifold3d",
    "mana-sim",
    "numpy",
    "open3d",
    "pybullet",
    "scipy",
    "simready-validate",
    "trimesh",
    "usd-core",
    "vhacdx",
    "vtk",
)


@cache
def library_versions() -> dict[str, str]:
    """Installed version by distribution name."""
    return {name: version(name) for name in _LIBRARIES}
