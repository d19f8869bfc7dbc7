"""Reads a URDF or MJCF file into a source model: what its links look like at rest, how they move, what they weigh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from assetkit.readers.robot.masses import stated_masses
from assetkit.readers.robot.mesh_axes import mesh_turn
from assetkit.readers.robot.shapes import SurfaceReader, shape_name, usable, visible_shapes
from assetkit.readers.source_format import Reader
from assetkit.sources.source_file import SourceFile
from formats import read_mjcf, read_urdf
from formats.mechanism import MechanismReading, read_mechanism
from formats.missing_limits import with_missing_limits
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.evidence import declared
from schemas.files.references import expected_path
from schemas.model import Mesh, Model, Node
from schemas.outcome import INTAKE, Outcome, Repair
from schemas.robot_description import RobotDescription

MOST_SHAPES_READ = 20_000  # a house of furniture has a few thousand
MOST_TRIANGLES_READ = 5_000_000  # 10,000 capsules have 22 million, 5 GiB; real descriptions have below one million
UP_CONFIDENCE = 0.9  # z is up by convention of the formats; some exporters write y-up models all the same
# Notes of the description that the reader answers with a repair, or that concern shapes which it does not use.
_OF_SHAPES = ("robot/unsupported-shape", "robot/invalid-size", "robot/missing-mesh")


def read_robot(source: SourceFile, mesh_readers: Mapping[str, Reader]) -> Outcome[Model]:
    """The model in a description file: all meshes at the rest state, in the frame of its root, metres, z up.

    `mesh_readers` are those of mesh files, by extension with dot. Raises InvalidInput: codes `robot/...` of the
    description (`formats`, `formats.mechanism`), those of the mesh readers, `asset/empty-geometry`.
    """
    where = Location(file=source.relative)
    description = (read_urdf if source.path.suffix.lower() == ".urdf" else read_mjcf)(source.path, source.root)
    _log_files(source, description)
    _require_whole(description)
    shapes = {link.name: visible_shapes(link) for link in description.links}
    if sum(map(len, shapes.values())) > MOST_SHAPES_READ:
        count = sum(map(len, shapes.values()))
        headline = f"the description has {count} shapes"
        raise InvalidInput(finding("asset/resource-limit", headline, where=where, value=count, bound=MOST_SHAPES_READ))
    if not any(shapes.values()):
        _raise_problem(description)
        raise InvalidInput(finding("asset/empty-geometry", "no link has a shape", where=where))
    reading = read_mechanism(description, [name for name, visible in shapes.items() if visible])
    surfaces = SurfaceReader(source, mesh_readers, mesh_materials_count=description.format == "urdf")
    meshes = _meshes(description, reading, surfaces)
    surfaces.finish()
    masses, mass_repairs = stated_masses(description, reading.link_of, reading.X_ML, meshes)
    mechanism, joint_repairs = reading.mechanism, reading.repairs
    if mechanism is not None:
        mechanism, joint_repairs = with_missing_limits(mechanism, meshes, reading.repairs)
    name = description.format.upper()
    model = Model(
        meshes=meshes,
        materials=tuple(surfaces.materials),
        textures=surfaces.textures,
        nodes=_nodes(description, meshes),
        meters_per_unit=declared(1.0, f"{name}: metres"),
        up_axis=declared("z", f"{name}: z is up", confidence=UP_CONFIDENCE),
        metadata={"name": description.name} if description.name else {},
        masses=masses,
        mechanism=mechanism,
    )
    repairs = (*surfaces.repairs, *_note_repairs(description), *joint_repairs, *mass_repairs)
    return Outcome(model, (*_notes(description), *reading.notes, *surfaces.diagnostics), repairs)


def _meshes(description: RobotDescription, reading: MechanismReading, surfaces: SurfaceReader) -> tuple[Mesh, ...]:
    """The visible meshes of all links at rest, each with the body that it belongs to. Raises InvalidInput."""
    meshes: list[Mesh] = []
    count = 0
    for link in description.links:
        shapes = visible_shapes(link)
        for index, shape in enumerate(shapes):
            X_MS = reading.X_ML[link.name] @ shape.X_LS
            path = f"/{link.name}/{shape_name(shape, link.name, shapes)}_{index}"
            turn = mesh_turn(shape, link, surfaces)
            of_shape = surfaces.surfaces(shape, X_MS, shape_name(shape, link.name, shapes), path, turn)
            meshes += [replace(mesh, link=reading.link_of[link.name]) for mesh in of_shape]
            count += sum(len(mesh.triangles) for mesh in of_shape)
            if count > MOST_TRIANGLES_READ:
                headline = f"the shapes have more than {MOST_TRIANGLES_READ} triangles together"
                bound = MOST_TRIANGLES_READ
                raise InvalidInput(
                    finding("asset/resource-limit", headline, value=count, bound=bound, unit="triangles")
                )
    return tuple(meshes)


def _nodes(description: RobotDescription, meshes: tuple[Mesh, ...]) -> tuple[Node, ...]:
    """One node per link, with the meshes of its shapes."""
    owned: dict[str, list[int]] = {}
    for index, mesh in enumerate(meshes):
        owned.setdefault(mesh.source_path.split("/")[1], []).append(index)
    return tuple(Node(f"/{link.name}", np.eye(4), tuple(owned.get(link.name, ()))) for link in description.links)


def _require_whole(description: RobotDescription) -> None:
    """Raises InvalidInput where the file has elements that make bodies and are not read."""
    for element in description.unread:
        if element.changes_bodies:
            headline = f"<{element.tag}> makes bodies that only MuJoCo can expand"
            where = element.source.location
            raise InvalidInput(finding("robot/unsupported-shape", headline, where=where, value=element.tag))


def _raise_problem(description: RobotDescription) -> None:
    """Raises InvalidInput for the first mesh that cannot be read, if there is one."""
    meshes = [shape.mesh for link in description.links for shape in link.shapes if shape.mesh is not None]
    for problem in (mesh.problem for mesh in meshes if mesh.problem is not None):
        raise InvalidInput(problem.model_copy(update={"severity": Severity.ERROR}))


def _notes(description: RobotDescription) -> list[Diagnostic]:
    """The description's own findings; errors about shapes count where a shape is used, else they only inform."""
    return [
        note.model_copy(update={"severity": Severity.INFO})
        if note.severity is Severity.ERROR and note.code in _OF_SHAPES
        else note
        for note in description.notes
    ]


def _note_repairs(description: RobotDescription) -> list[Repair]:
    """A repair for every name that was taken, attribute that engines ask for, and axis that is no unit vector."""
    answers = {
        "robot/duplicate-name": "first_of_name",
        "robot/missing-attribute": "default_attribute",
        "robot/axis-not-unit": "unit_axis",
    }
    return [
        Repair(name=answers[n.code], code=n.code, stage=INTAKE, before={"finding": n.headline}, after={"finding": "-"})
        for n in description.notes
        if n.code in answers
    ]


def _log_files(source: SourceFile, description: RobotDescription) -> None:
    """Every file that the description is made of counts as read, absent meshes as missing."""
    lines = [link.source for link in description.links] + [joint.source for joint in description.joints]
    shapes = [shape for link in description.links for shape in link.shapes]
    lines += [shape.source for shape in shapes]
    lines += [shape.mesh.source for shape in shapes if shape.mesh is not None]
    root = source.root.resolve()
    for file in sorted({line.file for line in lines if line.file}):
        path = (root / file).resolve()
        if path.is_file() and path.is_relative_to(root):
            source.visited.add(path)
    for mesh in (shape.mesh for shape in shapes if shape.mesh is not None and not usable(shape)):
        expected = expected_path(mesh.uri, base=source.path.parent, root=source.root)
        if not mesh.path and expected is not None:
            source.missing.add(expected)
