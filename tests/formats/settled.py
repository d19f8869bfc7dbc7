"""One row of a table of settled differences: an input, what each reader did before `formats`, what is decided now.

The readers before: replay's (URDF, MJCF) and the sim gap's (URDF). `code` refuses the file; with `None` the file is
read, and `holds` states what the description must say.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from schemas.diagnostics import InvalidInput
from schemas.robot_description import DescribedJoint, DescribedShape, RobotDescription
from tests.support.bad_inputs.robot import Files, write

Holds = Callable[[RobotDescription], object]

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


class Case(NamedTuple):
    """`replay` and `simgap`: what the readers before did; "-" where the reader had no such input."""

    files: Files
    replay: str
    simgap: str
    code: str | None
    holds: Holds = lambda description: True
    notes: tuple[str, ...] = ()


def one_shape(d: RobotDescription) -> DescribedShape:
    return next(shape for link in d.links for shape in link.shapes)


def moving(d: RobotDescription) -> DescribedJoint:
    return next(joint for joint in d.joints if joint.moves)


def mesh_path(d: RobotDescription) -> str:
    mesh = one_shape(d).mesh
    assert mesh is not None
    return mesh.path


def check_case(case: Case, read: Callable[[Path, Path], RobotDescription], folder: Path) -> None:
    """Reads the files of a case in a folder and compares with what is decided."""
    path = write(case.files, folder)
    if case.code is not None:
        with pytest.raises(InvalidInput) as refused:
            read(path, folder)
        assert refused.value.diagnostic.code == case.code
        assert refused.value.diagnostic.where.file
        assert refused.value.diagnostic.where.line
        return
    description = read(path, folder)
    assert case.holds(description)
    harmless = ("robot/missing-inertial", "robot/unread-element", "robot/missing-limit")
    codes = tuple(note.code for note in description.notes)
    assert tuple(c for c in codes if c in case.notes or c not in harmless) == case.notes
