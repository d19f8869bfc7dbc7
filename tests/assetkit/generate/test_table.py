"""Every generator keeps the promises of the protocol, at the ends of its ranges and for seeded random parameters."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

from assetkit.generate.generator import GeneratedObject, Generator
from assetkit.generate.parameters import ParameterError, parameters_of, random_parameters
from assetkit.generate.shape import Shape, box
from assetkit.generate.table import GENERATORS
from assetkit.generate.write import mechanism_of
from geom.mechanism_pose import link_frames
from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.rays import Rays
from schemas.mechanism import Mechanism

SEEDS, CORNERS = (0,), 1
NO_OVERLAP_M3 = 1e-12  # a cubic tenth of a millimetre: rounding of faces that touch


def cases(generator: Generator[Any]) -> Iterator[Any]:
    """Least and greatest values together, ends by chance, and seeded random values."""
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
                    bodies = [body for body in part.shape.solid.decompose() if body.volume() > 0.0]
                    assert len(bodies) == 1, (thing.name, part.name, values)  # a sealed cavity has a negative volume
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
                assert is_open(solids[inside.link], low, high, np.array(inside.direction)), (thing.name, values)
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


def is_open(solid: Manifold, low: np.ndarray, high: np.ndarray, direction: np.ndarray) -> bool:
    """Whether a ray from near the ground of an inside, beside its middle, leaves it: not even a film closes it."""
    beside = 0.5 * (low + high) + 0.1 * (high - low) * (direction == 0.0)
    start = np.where(direction > 0.0, low + 1e-4, beside)
    return bool(np.isinf(Rays(*manifold_arrays(solid)).hit_distances(start[None], direction))[0])


def test_a_joint_that_goes_too_far_would_be_seen() -> None:
    """The law above finds a drawer that is pushed through the back of its case."""
    (unit,) = GENERATORS["drawer_unit"].run().objects
    through = solids_at(unit, mechanism_of(unit), {"drawer_1": -0.02})
    assert list(overlaps(through)) == [("body", "drawer_1")]


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
