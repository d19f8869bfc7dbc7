"""The files that truth tables refer to, and the object of each file that a table describes."""

from __future__ import annotations

from pathlib import Path

import pybullet_data

from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Intake
from assetkit.stages.intake import ReadSource


def roots(assets: Path) -> dict[str, Path]:
    """Folders by the names that the tables use: the development assets, and what the installed PyBullet brings."""
    return {"dev": assets, "pybullet": Path(pybullet_data.getDataPath())}


def located(assets: Path, path: str) -> tuple[Path, Path]:
    """The file of a path that begins with the name of its root, and that root."""
    name, _, below = path.partition("/")
    root = roots(assets)[name]
    return root / below, root


def largest(file: Path, options: Options, root: Path | None = None) -> Intake | None:
    """The object with most points, the first of equals; None when intake refuses the file."""
    (candidate,) = discover([file], root=root)
    return max(
        ReadSource().run(candidate, options).objects,
        key=lambda o: sum(len(m.points) for m in o.model.meshes),
        default=None,
    )


def object_of(file: Path, options: Options, root: Path) -> Intake:
    """The same of a file that intake does not refuse."""
    item = largest(file, options, root)
    assert item is not None, f"{file} is not refused"
    return item
