"""Generated objects come out of the pipeline as they were built: joints, masses, volumes of insides, open holes.

Each is taken through all stages with seeded random parameters and compared with `truth.json`: axes within 0.1 degrees,
limits within 1e-6, masses and volumes within 1 %.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom

from assetkit.affordances.anchors import propose_anchors
from assetkit.generate.generator import Generator
from assetkit.generate.parameters import parameters_of, random_parameters
from assetkit.generate.table import GENERATORS
from assetkit.generate.truth import TRUTH_FILE, GeneratedTruth, TrueHole, TrueInterior, TrueJoint, TrueLink, TrueObject
from geom.convex.support_function import surface
from geom.features.cavities import find_cavities
from schemas.anchors import Anchor, ContainmentVolume
from schemas.asset import AssetRecord
from schemas.physics import Solid
from usdio.reread.body import reread_package, visible_meshes

pytestmark = pytest.mark.long  # 10 to 40 s of processor time for each generator
SEED = 3
# A set is as good as its first member and one more; one member of each kind is enough.
FEWEST = {"rings": 1, "blocks": 1, "discs": 3, "levels": 1, "buttons": 1, "knobs": 1}
MOST_AXIS_DEG, MOST_LIMIT, MOST_SHARE = 0.1, 1e-6, 0.01
ABOVE_M, ASIDE_M, DROP_S = 0.002, (0.0003, 0.0002), 2.0  # where a thing is let go, and for how long
# A hole stays as wide as this share of it in the released colliders: chords of 16 sectors take 1.9 %.
LEAST_OPEN = 0.97


@dataclass(frozen=True)
class ReleasedSet:
    """A library made by `mana assets generate`, its truth, and the exit code of the command."""

    library: Path
    truth: GeneratedTruth
    exit_code: int

    def folder(self, thing: TrueObject) -> Path:
        return self.library / thing.name

    def record(self, thing: TrueObject) -> AssetRecord:
        return AssetRecord.model_validate_json((self.folder(thing) / "record.json").read_bytes())


def settings(generator: Generator[Any]) -> Iterator[str]:
    """Random parameters as `--set key=value`, with few members of sets."""
    values = random_parameters(generator.parameters, np.random.default_rng(SEED))
    for parameter in parameters_of(generator.parameters):
        yield f"{parameter.name}={FEWEST.get(parameter.name, getattr(values, parameter.name))}"


@pytest.fixture(scope="module", params=list(GENERATORS))
def released(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> ReleasedSet:
    out = tmp_path_factory.mktemp(request.param)
    command = [sys.executable, "-m", "cli.main", "assets", "generate", request.param, "--jobs", "1", "--json"]
    command += [word for text in settings(GENERATORS[request.param]) for word in ("--set", text)]
    done = subprocess.run([*command, "--out", str(out)], capture_output=True, text=True, timeout=300, check=False)
    truth = GeneratedTruth.model_validate_json(Path(json.loads(done.stdout)["truth"]).read_bytes())
    assert (out / "sources" / request.param / TRUTH_FILE).is_file()
    return ReleasedSet(out, truth, done.returncode)


def test_every_object_is_accepted(released: ReleasedSet) -> None:
    assert released.exit_code == 0
    outcomes = {thing.name: released.record(thing).outcome.value for thing in released.truth.objects}
    assert outcomes == dict.fromkeys(outcomes, "accepted")


def test_masses_and_volumes_are_those_that_were_built(released: ReleasedSet) -> None:
    for thing in released.truth.objects:
        physics = released.record(thing).physics
        sections = {link.name: link for link in physics.links} or {thing.links[0].name: physics}
        assert set(sections) == {link.name for link in thing.links}
        for link in thing.links:
            section = sections[link.name]
            require_mass(link, section)
            volume = section.mass_kg.value / section.density_kgm3.value
            assert volume == pytest.approx(link.volume_m3, rel=MOST_SHARE), (thing.name, link.name)


def require_mass(link: TrueLink, section: Any) -> None:
    assert section.mass_kg.value == pytest.approx(link.mass_kg, rel=MOST_SHARE)
    assert section.centre_of_mass_m.value == pytest.approx(link.centre_of_mass_m, abs=1e-4)
    trace = float(np.trace(link.inertia_kgm2))
    assert np.array(section.inertia_kgm2.value) == pytest.approx(np.array(link.inertia_kgm2), abs=MOST_SHARE * trace)


def test_joints_are_those_that_were_built(released: ReleasedSet) -> None:
    for thing in released.truth.objects:
        joints = {joint.value["name"]: joint.value for joint in released.record(thing).physics.joints}
        assert set(joints) == {joint.name for joint in thing.joints}
        for joint in thing.joints:
            require_joint(joint, joints[joint.name])


def require_joint(joint: TrueJoint, read: dict[str, Any]) -> None:
    assert (read["type"], read["parent"], read["child"]) == (joint.kind, joint.parent, joint.child)
    cosine = float(np.dot(read["axis"], joint.axis))
    assert np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))) < MOST_AXIS_DEG
    off_m = np.cross(np.array(read["anchor_m"]) - joint.anchor_m, joint.axis)
    assert np.linalg.norm(off_m) < 1e-4 or joint.kind == "prismatic"
    limits = read.get("limits_rad", read.get("limits_m"))
    assert limits == (None if joint.limits is None else pytest.approx(joint.limits, abs=MOST_LIMIT))
    numbers = (joint.damping, joint.friction, joint.stiffness)
    assert (read.get("damping", 0.0), read.get("friction", 0.0), read.get("stiffness", 0.0)) == pytest.approx(numbers)


def test_insides_that_open_upwards_hold_what_was_built(released: ReleasedSet) -> None:
    """Of the released surface of each link by itself; of a rigid object also its verified anchor."""
    for thing in released.truth.objects:
        upward = [inside for inside in thing.interiors if inside.direction == (0.0, 0.0, 1.0)]
        for inside in upward:
            solid = released_surface(released.folder(thing), inside.link if len(thing.links) > 1 else None)
            proposed = propose_anchors(solid, find_cavities(solid))
            assert volume_error(inside, proposed) < MOST_SHARE, (thing.name, inside)
        if upward and len(thing.links) == 1:
            anchors = [anchor.value for anchor in released.record(thing).anchors]
            assert volume_error(upward[0], anchors) < MOST_SHARE, thing.name


def released_surface(folder: Path, link: str | None) -> Solid:
    """The rendered meshes of a link, or of the whole object, in its own frame."""
    stage = Usd.Stage.Open(str(next((folder / "usd").glob("*.usda"))))
    points, triangles = list[np.ndarray](), list[np.ndarray]()
    for prim in visible_meshes(stage):
        if link is None or link in str(prim.GetPath()).split("/"):
            mesh = UsdGeom.Mesh(prim)
            triangles.append(np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3) + sum(map(len, points)))
            points.append(np.array(mesh.GetPointsAttr().Get(), dtype=np.float64))
    return Solid(np.concatenate(points), np.concatenate(triangles).astype(np.int32), "closed")


def volume_error(inside: TrueInterior, anchors: Sequence[Anchor]) -> float:
    """The share by which the best of the containment volumes differs; 1 where there is none."""
    volumes = [anchor.volume_m3 for anchor in anchors if isinstance(anchor, ContainmentVolume)]
    return min((abs(volume / inside.volume_m3 - 1.0) for volume in volumes), default=1.0)


def test_holes_for_other_objects_stay_open_in_the_released_colliders(released: ReleasedSet) -> None:
    """What goes in passes: the hole is wider than it, and nearly as wide as it was built."""
    clearances = {clearance.outer: clearance for clearance in released.truth.clearances}
    for thing in released.truth.objects:
        for hole in (hole for hole in thing.holes if thing.name in clearances):
            free_m = free_width_m(released.folder(thing), hole)
            assert free_m > hole.width_m - clearances[thing.name].clearance_m, (thing.name, hole)
            assert free_m >= LEAST_OPEN * hole.width_m or hole.depth_m is not None, (thing.name, hole)


def free_width_m(folder: Path, hole: TrueHole) -> float:
    """Diameter of the widest upright cylinder about the axis of the hole between the shapes above its ground."""
    ground_m = hole.centre_m[2] - hole.depth_m + 1e-3 if hole.depth_m is not None else -1.0
    package = reread_package(next((folder / "usd").glob("*.usda")))
    corners = [surface(shape)[0] for shape in package.body.shapes]
    outlines = [shapely.MultiPoint(c[:, :2]).convex_hull for c in corners if c[:, 2].max() > ground_m]
    return 2.0 * min(outline.distance(shapely.Point(hole.centre_m[:2])) for outline in outlines)


def test_what_goes_together_slides_together_in_mujoco(released: ReleasedSet) -> None:
    """The thing with the hole, let go 2 mm above the other one and a little aside, sinks as deep as the two were built.

    A recess is turned upside down over what goes in. Rings and discs come to rest on the base of their rod, a socket on
    the grip of its plug.
    """
    things = {thing.name: thing for thing in released.truth.objects}
    for clearance in released.truth.clearances:
        inner, outer = things.get(clearance.inner), things.get(clearance.outer)
        if inner is None or outer is None or inner is outer:
            continue
        (hole,) = outer.holes
        bottom_m, top_m = lowest_after_drop(released, inner, outer, hole)
        depth_m = hole.depth_m - clearance.clearance_m if hole.depth_m is not None else 0.7 * top_m
        assert bottom_m < top_m - depth_m + 1e-3, (outer.name, bottom_m, top_m)


def lowest_after_drop(
    released: ReleasedSet, inner: TrueObject, outer: TrueObject, hole: TrueHole
) -> tuple[float, float]:
    """Height at which the lower end of `outer` comes to rest, and that of the upper end of `inner` (m)."""
    twins = [next((released.folder(thing) / "export").glob("*.urdf")) for thing in (inner, outer)]
    top_m = float(reread_package(next((released.folder(inner) / "usd").glob("*.usda"))).visual_points[:, 2].max())
    turned_m = hole.centre_m[2] if hole.depth_m is not None else 0.0
    world = mujoco.MjSpec()
    world.attach(mujoco.MjSpec.from_file(str(twins[0])), prefix="inner_", frame=world.worldbody.add_frame())
    place = [*ASIDE_M, top_m + ABOVE_M + turned_m]
    body = world.worldbody.add_body(pos=place, quat=[0.0, 1.0, 0.0, 0.0] if turned_m else [1.0, 0.0, 0.0, 0.0])
    body.add_freejoint()
    world.attach(mujoco.MjSpec.from_file(str(twins[1])), prefix="outer_", frame=body.add_frame())
    model = world.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=round(DROP_S / model.opt.timestep))
    return float(data.qpos[2]) - turned_m, top_m
