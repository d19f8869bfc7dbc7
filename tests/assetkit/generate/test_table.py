"""Every generator keeps the promises of the protocol, at the ends of its ranges and for seeded random parameters."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from assetkit.generate.generator import GeneratedObject, Generator
from assetkit.generate.parameters import ParameterError, parameters_of, random_parameters
from assetkit.generate.shape import Shape, box, cylinder
from assetkit.generate.table import GENERATORS
from assetkit.generate.truth import TRUTH_FILE, GeneratedTruth
from assetkit.generate.write import MESHES, mechanism_of, write_set
from assetkit.taxonomy.material_classes import materials
from formats import link_mass, read_mjcf, read_urdf
from geom.mechanism_pose import link_frames
from geom.pose import apply
from schemas.mechanism import Mechanism
from schemas.robot_description import DescribedShape
from tests.support.present import present

SEEDS, CORNERS = (0, 1), 2
NO_OVERLAP_M3 = 1e-12  # a cubic tenth of a millimetre: rounding of faces that touch


def cases(generator: Generator[Any]) -> Iterator[Any]:
    """Defaults, least and greatest values together, ends by chance, and seeded random values."""
    yield generator.parameters()
    count = len(parameters_of(generator.parameters))
    ends = np.random.default_rng(9).integers(0, 2, (CORNERS, count)).astype(bool).tolist()
    for corner in ([False] * count, [True] * count, *ends):
        yield at_ends(generator, corner)
    for seed in SEEDS:
        yield random_parameters(generator.parameters, np.random.default_rng(seed))


def at_ends(generator: Generator[Any], upper: list[bool]) -> Any:
    """Each parameter at its upper or lower end; a choice is the last or the first."""
    values: dict[str, float | int | str] = {}
    for parameter, is_upper in zip(parameters_of(generator.parameters), upper, strict=True):
        end = parameter.high if is_upper else parameter.low
        values[parameter.name] = int(end) if parameter.whole else end
        if parameter.choices:
            values[parameter.name] = parameter.choices[-1 if is_upper else 0]
    return generator.parameters(**values)


@pytest.fixture(params=list(GENERATORS))
def generator(request: pytest.FixtureRequest) -> Generator[Any]:
    return GENERATORS[request.param]


def solids_at(thing: GeneratedObject, mechanism: Mechanism, positions: dict[str, float]) -> dict[str, Shape]:
    """One shape per link, where the joints put it."""
    frames = link_frames(mechanism, positions)
    origins = {link.name: link.origin for link in mechanism.links}
    posed: dict[str, Shape] = {}
    for link in thing.links:
        X = frames[link.name].copy()
        X[:3, 3] -= X[:3, :3] @ origins[link.name]
        whole = link.parts[0].shape
        for part in link.parts[1:]:
            whole = whole + part.shape
        posed[link.name] = Shape(whole.solid.transform(np.ascontiguousarray(X[:3])), ())
    return posed


def overlaps(posed: dict[str, Shape]) -> dict[tuple[str, str], float]:
    """Volume (m3) that two links share, where it is more than rounding."""
    shared = {(a, b): (posed[a].solid ^ posed[b].solid).volume() for a, b in combinations(posed, 2)}
    return {pair: volume for pair, volume in shared.items() if volume > NO_OVERLAP_M3}


def test_parts_are_closed_bodies_that_touch_and_do_not_overlap(generator: Generator[Any]) -> None:
    for values in cases(generator):
        for thing in generator.run(values).objects:
            for link in thing.links:
                for part in link.parts:
                    mesh = trimesh.Trimesh(*part.shape.surface, process=False)
                    assert mesh.is_watertight, (thing.name, part.name, values)
                    assert mesh.volume > 0.0, (thing.name, part.name, values)
                for a, b in combinations(link.parts, 2):
                    assert (a.shape.solid ^ b.shape.solid).volume() <= NO_OVERLAP_M3, (thing.name, a.name, b.name)


def test_links_do_not_meet_at_rest_nor_at_the_ends_and_middle_of_any_joint(generator: Generator[Any]) -> None:
    for values in cases(generator):
        for thing in generator.run(values).objects:
            mechanism = mechanism_of(thing)
            states: list[dict[str, float]] = [{}]
            for joint in thing.joints:
                low, high = joint.limits or (-np.pi, np.pi)
                states += [{joint.name: at} for at in (low, 0.5 * (low + high), high)]
            for state in states:
                assert overlaps(solids_at(thing, mechanism, state)) == {}, (thing.name, state, values)


def test_insides_are_free_and_walls_begin_at_their_bounds(generator: Generator[Any]) -> None:
    """A box inside is empty and filled by nothing larger; a round or leaning one is smaller than its box."""
    for values in cases(generator):
        for thing in generator.run(values).objects:
            solids = {link.name: link.parts[0].shape.solid for link in thing.links}
            for inside in thing.interiors:
                low, high = np.array(inside.low_m), np.array(inside.high_m)
                box_m3 = float(np.prod(high - low))
                if inside.volume_m3 < (1.0 - 1e-9) * box_m3:
                    assert inside.volume_m3 > 0.5 * box_m3
                    continue
                assert inside.volume_m3 == pytest.approx(box_m3)
                assert (solids[inside.link] ^ box(low, high).solid).volume() <= NO_OVERLAP_M3, (thing.name, values)
                for axis in range(3):
                    grown = np.zeros(3)
                    grown[axis] = 1e-4
                    sides = [box(low - grown, high), box(low, high + grown)]
                    walls = [(solids[inside.link] ^ side.solid).volume() > NO_OVERLAP_M3 for side in sides]
                    assert walls == [True, inside.direction[axis] == 0.0], (thing.name, inside.name, axis)


def test_a_joint_that_goes_too_far_would_be_seen() -> None:
    """The law above finds a drawer that is pushed through the back of its case."""
    (unit,) = GENERATORS["drawer_unit"].run().objects
    through = solids_at(unit, mechanism_of(unit), {"slide_1": -0.02})
    assert list(overlaps(through)) == [("body", "drawer_1")]


def test_truth_is_that_of_the_files(generator: Generator[Any], tmp_path: Path) -> None:
    """Mass, mass centre and inertia by another library, from the meshes as written and the densities of the table."""
    files = write_set(generator, generator.parameters(), tmp_path)
    truth = GeneratedTruth.model_validate_json((tmp_path / TRUTH_FILE).read_bytes())
    assert [thing.file for thing in truth.objects] == [file.name for file in files]
    for thing, file in zip(truth.objects, files, strict=True):
        read = read_urdf if file.suffix == ".urdf" else read_mjcf
        description = read(file, tmp_path)
        assert description.notes == ()
        anchors = {joint.child: np.array(joint.anchor_m) for joint in thing.joints}
        for link in thing.links:
            (described,) = [each for each in description.links if each.name == link.name]
            weighed: list[trimesh.Trimesh] = []
            for shape in described.shapes:
                if shape.drawn and not shape.collides and shape.mesh is not None and shape.material is not None:
                    mesh = trimesh.load_mesh(tmp_path / MESHES / Path(shape.mesh.uri).name, process=False)
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


def test_joints_of_the_files_are_those_of_the_truth_in_mujoco(generator: Generator[Any], tmp_path: Path) -> None:
    """An engine reads each source: the moving joints with axis, limits, damping, friction and spring."""
    files = write_set(generator, generator.parameters(), tmp_path)
    truth = GeneratedTruth.model_validate_json((tmp_path / TRUTH_FILE).read_bytes())
    for thing, file in zip(truth.objects, files, strict=True):
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


def test_the_same_parameters_give_the_same_bytes_and_others_do_not(generator: Generator[Any], tmp_path: Path) -> None:
    values = random_parameters(generator.parameters, np.random.default_rng(5))
    first, second, other = (
        written(generator, v, tmp_path / name)
        for name, v in (("first", values), ("second", values), ("other", generator.parameters()))
    )
    assert first == second
    assert first[TRUTH_FILE] != other[TRUTH_FILE]


def written(generator: Generator[Any], values: Any, folder: Path) -> dict[str, bytes]:
    write_set(generator, values, folder)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_objects_stand_with_their_bottom_centre_at_the_origin(generator: Generator[Any], tmp_path: Path) -> None:
    write_set(generator, generator.parameters(), tmp_path)
    truth = GeneratedTruth.model_validate_json((tmp_path / TRUTH_FILE).read_bytes())
    for thing in truth.objects:
        anchors = {joint.child: np.array(joint.anchor_m) for joint in thing.joints}
        points = [
            np.asarray(trimesh.load_mesh(file, process=False).vertices) + anchors.get(link.name, np.zeros(3))
            for link in thing.links
            for file in (tmp_path / MESHES).glob(f"{thing.name}_{link.name}*.obj")
            if "collision" not in file.name
        ]
        low, high = np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)
        assert np.array([*(low + high)[:2], low[2]]) == pytest.approx(np.zeros(3), abs=1e-9)


def test_collision_shapes_of_the_files_enclose_what_is_drawn(generator: Generator[Any], tmp_path: Path) -> None:
    """By their bounds in the frame of each link, to the depth of a chord."""
    for file in write_set(generator, generator.parameters(), tmp_path):
        description = (read_urdf if file.suffix == ".urdf" else read_mjcf)(file, tmp_path)
        for link in description.links:
            drawn = [corners_of(shape, tmp_path) for shape in link.shapes if not shape.collides]
            colliding = [corners_of(shape, tmp_path) for shape in link.shapes if shape.collides]
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


def test_parameters_outside_their_ranges_are_refused(generator: Generator[Any]) -> None:
    number = next(p for p in parameters_of(generator.parameters) if not p.choices)
    above = number.high + 1
    with pytest.raises(ParameterError) as refused:
        generator.run(generator.parameters(**{number.name: int(above) if number.whole else above}))
    assert f"{number.low:g} to {number.high:g}" in str(refused.value)


def test_names_of_the_table_are_those_of_the_files() -> None:
    folder = Path(__file__).parents[3] / "assetkit" / "generate" / "objects"
    assert list(GENERATORS) == sorted(path.stem for path in folder.glob("*.py") if path.name != "__init__.py")
    for generator in GENERATORS.values():
        for parameter in parameters_of(generator.parameters):
            assert parameter.about, (generator.name, parameter.name)


def test_a_name_goes_before_those_of_a_set(tmp_path: Path) -> None:
    files = write_set(GENERATORS["charger"], GENERATORS["charger"].parameters(), tmp_path, "desk")
    assert [file.name for file in files] == ["desk_charger_plug.urdf", "desk_charger_socket.urdf"]
    truth = GeneratedTruth.model_validate_json((tmp_path / TRUTH_FILE).read_bytes())
    assert (truth.clearances[0].inner, truth.clearances[0].outer) == ("desk_charger_plug", "desk_charger_socket")
    (file,) = write_set(GENERATORS["turntable"], GENERATORS["turntable"].parameters(), tmp_path / "one", "spinner")
    assert file.name == "spinner.urdf"
