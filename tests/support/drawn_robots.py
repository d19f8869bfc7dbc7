"""Random robot descriptions for laws, and the comparison of two descriptions that leaves out places and findings."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from hypothesis import strategies as st

from geom.pose import matrix_of, pose
from schemas.robot_description import (
    WORLD_LINK,
    DescribedCamera,
    DescribedJoint,
    DescribedLink,
    DescribedMaterial,
    DescribedShape,
    DescribedShapeKind,
    Inertial,
    JointKind,
    JointLimits,
    MeshReference,
    Mimic,
    RobotDescription,
    ShapeFriction,
)

Format = Literal["urdf", "mjcf"]
POSE_TOLERANCE = 1e-9  # metres and matrix entries: poses go through angles or quaternions
NOT_COMPARED = frozenset({"source", "notes", "problem", "settings", "path"})

numbers = st.floats(-3.0, 3.0).map(lambda v: 0.0 if abs(v) < 1e-6 else v)
sizes = st.floats(0.01, 2.0)
amounts = st.one_of(st.just(0.0), st.floats(0.01, 50.0))
vectors = st.tuples(numbers, numbers, numbers)
words = st.text(
    st.characters(codec="utf-8", categories=("L", "N"), include_characters="<>&\"'_-. /"), min_size=1, max_size=8
)
quats = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
colors = st.tuples(*[st.floats(0.0, 1.0)] * 4)


@st.composite
def poses(draw: st.DrawFn) -> np.ndarray:
    R = matrix_of(np.array(draw(quats))) if draw(st.booleans()) else None
    return pose(R, np.array(draw(vectors)))


@st.composite
def axes(draw: st.DrawFn) -> np.ndarray:
    axis = np.array(draw(vectors.filter(lambda v: np.linalg.norm(v) > 0.1)))
    return axis / np.linalg.norm(axis)


@st.composite
def inertials(draw: st.DrawFn) -> Inertial:
    edges = np.array(draw(st.tuples(sizes, sizes, sizes)))
    moments = np.array([edges[1] ** 2 + edges[2] ** 2, edges[0] ** 2 + edges[2] ** 2, edges[0] ** 2 + edges[1] ** 2])
    R = matrix_of(np.array(draw(quats))) if draw(st.booleans()) else np.eye(3)
    tensor = R @ np.diag(moments) @ R.T
    return Inertial(draw(st.floats(0.01, 50.0)), draw(poses()), (tensor + tensor.T) / 2.0)


@st.composite
def shapes(draw: st.DrawFn, form: Format, k: int) -> DescribedShape:
    kinds: list[DescribedShapeKind] = ["box", "sphere", "cylinder", "capsule", "mesh"]
    if form == "mjcf":
        kinds = [*kinds, "ellipsoid", "plane"]
    kind = draw(st.sampled_from(kinds))
    count = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "mesh": 0, "ellipsoid": 3, "plane": 2}[kind]
    material = draw(st.none() | st.builds(DescribedMaterial, st.just(f"m{k}"), colors))
    drawn = form == "mjcf" or draw(st.booleans())
    weighs = form == "mjcf" and kind != "plane"
    mass_kg = draw(st.none() | st.floats(0.1, 5.0)) if weighs else None
    friction = draw(st.none() | st.floats(0.0, 2.0)) if form == "mjcf" or not drawn else None
    return DescribedShape(
        name=draw(st.just("") | words.map(lambda w: f"{w}{k}")),
        kind=kind,
        size_m=tuple(draw(sizes) for _ in range(count)),
        X_LS=draw(poses()),
        collides=draw(st.booleans()) if form == "mjcf" else not drawn,
        drawn=drawn,
        mesh=draw(meshes(form, k)) if kind == "mesh" else None,
        material=material if drawn else None,
        friction=None if friction is None else ShapeFriction(friction, friction),
        mass_kg=mass_kg,
        density_kgm3=draw(st.none() | st.floats(1.0, 9000.0)) if weighs and mass_kg is None else None,
        group=draw(st.integers(0, 5)) if form == "mjcf" else 0,
    )


@st.composite
def meshes(draw: st.DrawFn, form: Format, k: int) -> MeshReference:
    scale = draw(st.just((1.0, 1.0, 1.0)) | vectors.filter(all))
    if form == "urdf":
        return MeshReference(f"meshes/{draw(words)}.obj", scale=scale)
    reference = (
        {"reference_position_m": draw(vectors), "reference_quat_wxyz": draw(quats)} if draw(st.booleans()) else {}
    )
    if draw(st.booleans()):
        return MeshReference(f"meshes/{k}.obj", scale=scale, name=f"mesh{k}", **reference)
    vertices, triangles = np.array([draw(vectors) for _ in range(4)]), np.array([[0, 1, 2], [0, 2, 3]])
    return MeshReference("", scale=scale, name=f"mesh{k}", vertices=vertices, triangles=triangles, **reference)


@st.composite
def joints(draw: st.DrawFn, form: Format, name: str, parent: str, child: str) -> DescribedJoint:
    kinds: list[JointKind] = ["fixed", "revolute", "continuous", "prismatic", "ball"]
    if form == "urdf":
        kinds = [*kinds, "planar", "floating"]
    elif parent == WORLD_LINK:
        kinds = [*kinds, "floating"]
    kind = draw(st.sampled_from(kinds))
    X_PC = draw(poses())
    if kind in ("fixed", "floating"):
        welded = form == "mjcf" and kind == "fixed"
        return DescribedJoint(f"{child}_weld" if welded else name, kind, parent, child, X_PC, stated=not welded)
    turns_or_slides = kind in ("revolute", "continuous", "prismatic")
    mjcf = form == "mjcf"
    lower = draw(numbers)
    limits = (
        JointLimits(lower, lower + draw(sizes))
        if kind == "revolute" or (kind == "prismatic" and draw(st.booleans()))
        else None
    )
    return DescribedJoint(
        name=name,
        kind=kind,
        parent=parent,
        child=child,
        X_PC=X_PC,
        axis_C=draw(axes()) if kind != "ball" else np.array([0.0, 0.0, 1.0]),
        anchor_C=np.array(draw(vectors)) if mjcf else np.zeros(3),
        reference=draw(numbers) if mjcf and turns_or_slides else 0.0,
        limits=limits,
        effort=draw(st.none() | st.floats(0.1, 100.0)),
        velocity=draw(st.none() | sizes) if not mjcf else None,
        damping=draw(amounts),
        friction=draw(amounts),
        armature=draw(amounts) if mjcf else 0.0,
        stiffness=draw(amounts) if mjcf else 0.0,
        spring_reference=draw(numbers) if mjcf and turns_or_slides else 0.0,
    )


@st.composite
def descriptions(draw: st.DrawFn, form: Format) -> RobotDescription:
    """A tree of up to six links in the order in which the format's reader lists them."""
    stem = draw(words)
    count = draw(st.integers(1, 6))
    parents = [draw(st.integers(0, k - 1)) for k in range(1, count)]
    names = [WORLD_LINK if form == "mjcf" else f"{stem}0", *(f"{stem}{k}" for k in range(1, count))]
    carriers = [draw(joints(form, f"{stem}j{k}", names[p], names[k])) for k, p in enumerate(parents, 1)]
    if form == "mjcf":  # A second joint of one body.
        carriers = [
            joint
            for first in carriers
            for joint in (
                [first, dataclasses.replace(draw(hinges(first)), name=f"{first.name}+")]
                if first.kind in ("revolute", "prismatic") and draw(st.booleans())
                else [first]
            )
        ]
    links = [draw(described_links(form, name, k, names[0])) for k, name in enumerate(names)]
    description = RobotDescription(draw(words), form, tuple(links), tuple(with_mimics(draw, carriers)), names[0])
    return depth_first(description) if form == "mjcf" else description


def hinges(first: DescribedJoint) -> st.SearchStrategy[DescribedJoint]:
    return axes().map(lambda axis: dataclasses.replace(first, kind="continuous", axis_C=axis, limits=None))


def with_mimics(draw: st.DrawFn, carriers: list[DescribedJoint]) -> list[DescribedJoint]:
    """Some joints follow the first one that can be followed."""
    single = [j for j in carriers if j.kind in ("revolute", "continuous", "prismatic")]
    return [
        dataclasses.replace(joint, mimic=Mimic(single[0].name, draw(numbers), draw(numbers)))
        if joint in single[1:] and draw(st.booleans())
        else joint
        for joint in carriers
    ]


@st.composite
def described_links(draw: st.DrawFn, form: Format, name: str, k: int, root: str) -> DescribedLink:
    own_shapes = tuple(draw(shapes(form, 10 * k + i)) for i in range(draw(st.integers(0, 3))))
    inertial = draw(st.none() | inertials())
    cameras: tuple[DescribedCamera, ...] = ()
    if form == "mjcf":
        inertial = None if name == root else inertial
        cameras = tuple(
            DescribedCamera(f"c{k}_{i}", draw(poses()), draw(st.floats(0.1, 2.0)))
            for i in range(draw(st.integers(0, 1)))
        )
    weighs = any(shape.mass_kg is not None or shape.density_kgm3 is not None for shape in own_shapes) and name != root
    contact = (
        draw(st.dictionaries(st.sampled_from(["lateral_friction", "restitution"]), amounts)) if form == "urdf" else {}
    )
    source = "declared" if inertial is not None else "shapes" if weighs else "missing"
    return DescribedLink(name, own_shapes, inertial, source, contact, cameras)


def depth_first(description: RobotDescription) -> RobotDescription:
    """Links and joints in the order of MuJoCo."""
    below: dict[str, list[str]] = {}
    for joint in description.joints:
        if joint.child not in below.setdefault(joint.parent, []):
            below[joint.parent].append(joint.child)
    order, waiting = [], [description.root]
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1], []))
    links = {link.name: link for link in description.links}
    ordered = [j for name in order for j in description.joints if j.child == name]
    return dataclasses.replace(description, links=tuple(links[n] for n in order), joints=tuple(ordered))


def differences(a: Any, b: Any, where: str = "") -> list[str]:
    """Where two descriptions say something else; arrays to `POSE_TOLERANCE`, numbers exactly."""
    if dataclasses.is_dataclass(a) and type(a) is type(b):
        names = [f.name for f in dataclasses.fields(a) if f.name not in NOT_COMPARED]
        return [d for name in names for d in differences(getattr(a, name), getattr(b, name), f"{where}.{name}")]
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        close = a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=POSE_TOLERANCE)
        return [] if close else [f"{where}: {a.tolist()} {b.tolist()}"]
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return [] if dict(a) == dict(b) else [f"{where}: {a} {b}"]
    if isinstance(a, tuple) and isinstance(b, tuple):
        if len(a) != len(b):
            return [f"{where}: {len(a)} and {len(b)} entries"]
        return [d for k, (x, y) in enumerate(zip(a, b, strict=True)) for d in differences(x, y, f"{where}[{k}]")]
    if isinstance(a, float) and isinstance(b, float):
        return [] if np.isclose(a, b, rtol=1e-12, atol=1e-12) else [f"{where}: {a} {b}"]
    return [] if a == b else [f"{where}: {a!r} {b!r}"]
