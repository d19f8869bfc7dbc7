"""Finds the file that a mesh reference names: inside the root, or not at all."""

from __future__ import annotations

import re
from pathlib import Path

from schemas.diagnostics import Diagnostic, finding
from schemas.robot_description import SourceLine

_SCHEME = re.compile(r"^([A-Za-z][A-Za-z0-9+.-]+)://")  # two letters at least: `C:` is a drive
_PACKAGES = ("package", "model")  # of ROS and of Gazebo: the first word behind is the name of a package's folder


def mesh_file(uri: str, folder: Path, root: Path, source: SourceLine) -> tuple[str, Diagnostic | None]:
    """The file's path relative to `root`, or "" and the reason.

    `package://arm/hand.obj` is looked for below a folder `arm` that holds the description or lies beside one that
    does; `file://` and absolute names count if they lie inside the root; other names start from `folder`. Nothing
    outside the root is opened.
    """
    name = uri.replace("\\", "/")
    match = _SCHEME.match(name)
    scheme = match[1].lower() if match else ""
    rest = name[match.end() :] if match else name
    if scheme and scheme not in (*_PACKAGES, "file"):
        return "", finding(
            "robot/path-escape", f"mesh '{uri[:200]}' is no file of the folder", where=source.location, value=uri[:200]
        )
    places = _package_files(rest, folder, root) if scheme in _PACKAGES else [folder / rest]
    top = root.resolve()
    inside = [place for place in (_resolved(p) for p in places) if place is not None and place.is_relative_to(top)]
    hit = next((place for place in inside if place.is_file()), None)
    if hit is not None:
        return hit.relative_to(top).as_posix(), None
    code = "robot/missing-mesh" if inside or not places else "robot/path-escape"
    headline = f"mesh '{uri[:200]}' " + ("is absent" if code == "robot/missing-mesh" else "lies outside the folder")
    return "", finding(code, headline, where=source.location, value=uri[:200])


def _package_files(rest: str, folder: Path, root: Path) -> list[Path]:
    """Places of `<package>/<path>`: from the folder of the description upwards to the root."""
    package, _, path = rest.partition("/")
    top = root.resolve()
    places: list[Path] = []
    at = folder.resolve()
    while at.is_relative_to(top):
        places += [at / path] if at.name == package else []
        places.append(at / package / path)
        if at == top:
            break
        at = at.parent
    return places


def _resolved(path: Path) -> Path | None:
    """The path with links followed; None for a name that no file system can hold."""
    try:
        return path.resolve()
    except (OSError, ValueError, RuntimeError):
        return None
