"""Written sources: truth by another library, joints as an engine has them, colliders where shapes are, equal bytes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from assetkit.generate.generator import Generator
from assetkit.generate.parameters import random_parameters
from assetkit.generate.shape import cylinder
from assetkit.generate.table import GENERATORS
from assetkit.generate.truth import TRUTH_FILE, GeneratedTruth
from assetkit.generate.write import MESHES, write_set
from assetkit.taxonomy.material_classes import materials
from formats import link_mass, read_mjcf, read_urdf
from geom.pose import apply
from schemas.robot_description import DescribedShape
from tests.support.present import present


@dataclass(frozen=True)
class Sources:
    """What a generator writes for its default parameters."""

    generator: Generator[Any]
    folder: Path
    files: tuple[Path, ...]
    truth: GeneratedTruth


@pytest.fixture(scope="module", params=list(GENERATORS))
def sources(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Sources:
    generator, folder = GENERATORS[request.param], tmp_path_factory.mktemp(request.param)
    files = write_set(generator, generator.parameters(), folder)
    return Sources(generator, folder, files, GeneratedTruth.model_validate_json((folder / TRUTH_FILE).read_bytes()))


def test_truth_is_that_of_the_files(sources: Sources) -> None:
    """Mass, mass centre and inertia by another library, from the meshes as written and the densities of the table."""
    assert [thing.file for thing in sources.truth.objects] == [file.name for file in sources.files]
    for thing, file in zip(sources.truth.objects, sources.files, strict=True):
        read = read_urdf if file.suffix == ".urdf" else read_mjcf
        description = read(file, sources.folder)
        assert description.notes == ()
        anchors = {joint.child: np.array(joint.anchor_m) for joint in thing.joints}
        for link in thing.links:
            (described,) = [each for each in description.links if each.name == link.name]
            weighed: list[trimesh.Trimesh] = []
            for shape in described.shapes:
                if shape.drawn and not shape.collides and shape.mesh is not None and shape.material is not None:
                    mesh = trimesh.load_mesh(sources.folder / MESHES / Path(shape.mesh.uri).name, process=False)
                    mesh.density = materials()[shape.material.name.partition("_")[2]].density_kgm3
                    weighed.append(mesh)
            origin = anchors.get(link.name, np.zeros(3))
            mass = sum(mesh.mass for mesh in weighed)
            centre = sum(mesh.mass * mesh.center_mass for mesh in weighed) / mass + origin
            inertia = sum(
                mesh.moment_inertia + mesh.mass * parallel_axis(mesh.center_mass + origin - centre) for mesh in weighed
            )
            stated = present(link_mass(described))
            assert (stated.mass_kg, link.mass_kg) == pytest.approx((mass, mass), rel=1e-9)
            assert stated.centre_of_mass_m + origin == pytest.approx(centre, abs=1e-9)
            assert stated.inertia_kgm2 == pytest.approx(inertia, abs=1e-9 * np.trace(inertia))
            assert link.volume_m3 == pytest.approx(sum(mesh.volume for mesh in weighed), rel=1e-9)
            assert link.centre_of_mass_m == pytest.approx(centre, abs=1e-9)
            assert np.array(link.inertia_kgm2) == pytest.approx(inertia, abs=1e-9 * np.trace(inertia))


def parallel_axis(shift: np.ndarray) -> np.ndarray:
    return float(shift @ shift) * np.eye(3) - np.outer(shift, shift)


def test_joints_of_the_files_are_those_of_the_truth_in_mujoco(sources: Sources) -> None:
    """An engine reads each source: the moving joints with axis, limits, damping, friction and spring."""
    for thing, file in zip(sources.truth.objects, sources.files, strict=True):
        model = mujoco.MjSpec.from_file(str(file)).compile()
        assert model.njnt == len(thing.joints)
        for joint in thing.joints:
            read = model.joint(joint.name)
            assert read.axis == pytest.approx(joint.axis, abs=1e-9)
            assert bool(model.jnt_limited[read.id]) == (joint.limits is not None)
            if joint.limits is not None:
                assert read.range == pytest.approx(joint.limits, abs=1e-9)
            assert read.damping == pytest.approx(joint.damping)
            assert read.frictionloss == pytest.approx(joint.friction)
            assert read.stiffness == pytest.approx(joint.stiffness)


def test_the_same_parameters_give_the_same_bytes_and_others_do_not(sources: Sources, tmp_path: Path) -> None:
    generator = sources.generator
    write_set(generator, generator.parameters(), tmp_path / "again")
    write_set(generator, random_parameters(generator.parameters, np.random.default_rng(5)), tmp_path / "other")
    first, again, other = map(contents, (sources.folder, tmp_path / "again", tmp_path / "other"))
    assert first == again
    assert first[TRUTH_FILE] != other[TRUTH_FILE]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_objects_stand_with_their_bottom_centre_at_the_origin(sources: Sources) -> None:
    for thing in sources.truth.objects:
        anchors = {joint.child: np.array(joint.anchor_m) for joint in thing.joints}
        points = [
            np.asarray(trimesh.load_mesh(file, process=False).vertices) + anchors.get(link.name, np.zeros(3))
            for link in thing.links
            for file in (sources.folder / MESHES).glob(f"{thing.name}_{link.name}*.obj")
            if "collision" not in file.name
        ]
        low, high = np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)
        assert np.array([*(low + high)[:2], low[2]]) == pytest.approx(np.zeros(3), abs=1e-9)


def test_collision_shapes_of_the_files_enclose_what_is_drawn(sources: Sources) -> None:
    """By their bounds in the frame of each link, to the depth of a chord."""
    for file in sources.files:
        description = (read_urdf if file.suffix == ".urdf" else read_mjcf)(file, sources.folder)
        for link in description.links:
            drawn = [corners_of(shape, sources.folder) for shape in link.shapes if not shape.collides]
            colliding = [corners_of(shape, sources.folder) for shape in link.shapes if shape.collides]
            if drawn:
                bounds = [np.stack([c.min(axis=0), c.max(axis=0)]) for c in map(np.concatenate, (drawn, colliding))]
                assert bounds[1] == pytest.approx(bounds[0], abs=1e-6), (file.name, link.name)


def corners_of(shape: DescribedShape, folder: Path) -> np.ndarray:
    """Corners (n, 3) of a shape in the frame of its link; of a cylinder those of the polygon that is drawn."""
    if shape.mesh is not None:
        points = np.asarray(trimesh.load_mesh(folder / MESHES / Path(shape.mesh.uri).name, process=False).vertices)
    elif shape.kind == "box":
        signs = np.stack(np.meshgrid(*3 * [[-0.5, 0.5]], indexing="ij"), axis=-1).reshape(-1, 3)
        points = signs * shape.size_m
    else:
        points, _ = cylinder(shape.size_m[0], shape.size_m[1], (0.0, 0.0, -0.5 * shape.size_m[1])).surface
    return apply(shape.X_LS, points)


def test_a_name_goes_before_those_of_a_set(tmp_path: Path) -> None:
    files = write_set(GENERATORS["charger"], GENERATORS["charger"].parameters(), tmp_path, "desk")
    assert [file.name for file in files] == ["desk_charger_plug.urdf", "desk_charger_socket.urdf"]
    truth = GeneratedTruth.model_validate_json((tmp_path / TRUTH_FILE).read_bytes())
    assert (truth.clearances[0].inner, truth.clearances[0].outer) == ("desk_charger_plug", "desk_charger_socket")
    (file,) = write_set(GENERATORS["turntable"], GENERATORS["turntable"].parameters(), tmp_path / "one", "spinner")
    assert file.name == "spinner.urdf"
