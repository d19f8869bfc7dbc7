"""Statements of a description on the mass of its links, in the frame of the model, over the meshes of each body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from formats import link_mass
from formats.mjcf.geoms import WATER_KGM3
from geom.mass.inertia import combine, is_physical, moved
from schemas.arrays import FloatArray
from schemas.model import Mesh
from schemas.outcome import INTAKE, Repair
from schemas.physics import MassProperties
from schemas.robot_description import DescribedLink, RobotDescription
from schemas.stated_physics import StatedMass


def stated_masses(
    description: RobotDescription,
    link_of: Mapping[str, str],
    X_ML: Mapping[str, FloatArray],
    meshes: Sequence[Mesh],
) -> tuple[tuple[StatedMass, ...], tuple[Repair, ...]]:
    """One statement per body of the object whose links state a mass; a tensor that no body has is left out.

    `link_of` gives the body of each link. A mass that follows from MuJoCo's default density states nothing. Repairs
    name the links that have shapes and no usable mass: it will follow from the geometry.
    """
    members: dict[str, list[DescribedLink]] = {}
    for link in description.links:
        members.setdefault(link_of[link.name], []).append(link)
    statements: list[StatedMass] = []
    repairs: list[Repair] = []
    for body, links in members.items():
        covered = [mesh for mesh in meshes if mesh.link == body]
        if not covered:
            continue
        stated = [(link, mass) for link in links if (mass := _stated(link)) is not None]
        repairs += _repairs(description, links, bool(stated))
        if not stated:
            continue
        whole = combine([moved(mass, X_ML[link.name]) for link, mass in stated])
        complete = all(_has_tensor(link) for link, _ in stated)
        statements.append(
            StatedMass(
                covers=tuple(dict.fromkeys(mesh.source_path for mesh in covered)),
                triangles=sum(len(mesh.triangles) for mesh in covered),
                method=f"{description.format.upper()} inertial of {', '.join(link.name for link, _ in stated)}",
                where=stated[0][0].source.location,
                mass_kg=whole.mass_kg,
                centre=whole.centre_of_mass_m,
                inertia=whole.inertia_kgm2 if complete else None,
            )
        )
    return tuple(statements), tuple(repairs)


def _stated(link: DescribedLink) -> MassProperties | None:
    """The stated mass of a link in its frame; None where there is none, or only MuJoCo's default density."""
    if link.inertia_source == "shapes":
        weighing = [s for s in link.shapes if s.mass_kg is not None or s.density_kgm3 is not None]
        if not any(s.mass_kg is not None or s.density_kgm3 != WATER_KGM3 for s in weighing):
            return None
    return link_mass(link)


def _has_tensor(link: DescribedLink) -> bool:
    tensor = link.inertial.inertia_kgm2 if link.inertial is not None else None
    return link.inertia_source == "shapes" or (tensor is not None and is_physical(tensor))


def _repairs(description: RobotDescription, links: Sequence[DescribedLink], stated: bool) -> list[Repair]:
    """Repairs of stated masses and tensors that are impossible, and of moving bodies that MuJoCo finds massless."""
    repairs: list[Repair] = []
    for link in links:
        inertial = link.inertial
        if inertial is not None and inertial.mass_kg <= 0.0 and link.shapes:
            repairs.append(_repair("mass_from_geometry", "robot/invalid-mass", link, inertial.mass_kg))
        elif inertial is not None and inertial.inertia_kgm2 is not None and not _has_tensor(link):
            repairs.append(_repair("inertia_from_geometry", "robot/invalid-inertia", link, inertial.mass_kg))
        elif description.format == "mjcf" and link.inertia_source == "missing" and link.shapes and not stated:
            repairs.append(_repair("mass_from_geometry", "robot/missing-inertial", link, 0.0))
    return repairs


def _repair(name: str, code: str, link: DescribedLink, mass_kg: float) -> Repair:
    before: dict[str, float | int | str] = {"link": link.name, "stated_mass_kg": mass_kg}
    return Repair(name=name, code=code, stage=INTAKE, before=before, after={"link": link.name, "stated_mass_kg": "-"})
