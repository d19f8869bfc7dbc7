"""Physics of an articulated object: shapes and mass of each link as of a rigid prop, joints as evidence, and the sum.

All in the asset frame at rest, metres and kilograms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from assetkit.articulation.swept_volumes import swept_volumes
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.physics.build import PhysicsResult, build_physics
from assetkit.physics.link_clearance import clear_links
from assetkit.stage import LinkSurface, Physics
from geom.features.cavities import Cavity
from geom.mass.inertia import combine
from schemas.asset import LinkSection, PhysicsSection, matrix3, vec3
from schemas.diagnostics import Diagnostic
from schemas.evidence import Evidence, declared, inferred
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.outcome import Outcome
from schemas.package import LinkBody
from schemas.physics import CollisionShape, SurfaceMaterial
from schemas.stated_physics import StatedContact

BY_LINK = "by_link"  # the collision method of a whole mechanism; each link has its own


class _LinkPhysics(NamedTuple):
    link: MechanismLink
    result: PhysicsResult
    volume_m3: float


def link_physics(
    mechanism: Mechanism,
    surfaces: Sequence[LinkSurface],
    mass_inputs: MassEvidenceInputs,
    *,
    names: Sequence[str],
    contacts: Sequence[StatedContact],
    work_dir: Path,
    cavities: Mapping[str, tuple[Cavity, ...]] | None = None,
) -> Outcome[Physics]:
    """Physics of all links and of the whole; a person looks where the collider of a link misses its bounds.

    `cavities` are those of the solids of links, by name, where they are known.
    """
    by_name = {s.link: s for s in surfaces}
    parts: list[_LinkPhysics] = []
    for link in mechanism.links:
        inputs = _of_link(mass_inputs, link.name, by_name[link.name])
        folder = work_dir / link.name
        folder.mkdir(parents=True, exist_ok=True)
        result = build_physics(
            by_name[link.name].solid,
            names,
            work_dir=folder,
            mass_inputs=inputs,
            contacts=contacts,
            cavities=None if cavities is None else cavities.get(link.name),
        )
        parts.append(_LinkPhysics(link, result, result.section.mass_kg.value / result.section.density_kgm3.value))
    clearance = clear_links({p.link.name: p.result.shapes for p in parts}, mechanism)
    parts = [p._replace(result=replace(p.result, shapes=clearance.shapes[p.link.name])) for p in parts]
    heaviest = max(parts, key=lambda p: p.result.mass.mass_kg)
    surface_list = list(dict.fromkeys(s for p in (heaviest, *parts) for s in _surfaces(p.result)))
    shapes, shape_surfaces, bodies = list[CollisionShape](), list[int](), list[LinkBody]()
    for part in parts:
        first = len(shapes)
        shapes += part.result.shapes
        of_link = _surfaces(part.result)
        of_shape = part.result.shape_surfaces or (0,) * len(part.result.shapes)
        shape_surfaces += [surface_list.index(of_link[i]) for i in of_shape]
        bodies.append(LinkBody(part.link.name, tuple(range(first, len(shapes))), part.result.mass))
    physics = Physics(
        tuple(shapes),
        combine([p.result.mass for p in parts]),
        heaviest.result.contact,
        _section(mechanism, parts, heaviest),
        tuple(surface_list),
        tuple(shape_surfaces),
        tuple(bodies),
        clearance.filtered_pairs,
        swept_volumes(mechanism, {part.link.name: part.result.shapes for part in parts}),
    )
    found = [*(d for p in parts for d in p.result.diagnostics), *clearance.diagnostics]
    notes: dict[str, Diagnostic] = {d.model_dump_json(): d for d in found}
    repairs = (*(r for p in parts for r in p.result.repairs), *clearance.repairs)
    review = any(p.result.section.collider_misses_bounds for p in parts)
    return Outcome(physics, tuple(notes.values()), repairs, review=review)


def _surfaces(result: PhysicsResult) -> tuple[SurfaceMaterial, ...]:
    """The contact materials of a link, also where all its shapes share one."""
    section = result.section
    return result.surfaces or (SurfaceMaterial(section.material.value, section.density_kgm3.value, result.contact),)


def _of_link(inputs: MassEvidenceInputs, link: str, surface: LinkSurface) -> MassEvidenceInputs:
    """The evidence on one link: its own meshes; usual masses are those of whole objects."""
    of_face = inputs.material_of_face
    return replace(
        inputs,
        meshes=tuple(m for m in inputs.meshes if m.link == link),
        as_read=tuple(m for m in inputs.as_read if m.link == link),
        material_of_face=tuple(f for f, m in zip(of_face, inputs.meshes, strict=False) if m.link == link),
        wall=surface.wall,
        category="",
        category_range_kg=None,
        category_confidence=0.0,
    )


def _section(mechanism: Mechanism, parts: Sequence[_LinkPhysics], heaviest: _LinkPhysics) -> PhysicsSection:
    total = combine([p.result.mass for p in parts])
    masses = [p.result.section.mass_kg for p in parts]
    bounds = [m.bounds or (m.value, m.value) for m in masses]
    mass = _together(total.mass_kg, masses, (sum(b[0] for b in bounds), sum(b[1] for b in bounds)))
    volume = sum(p.volume_m3 for p in parts)
    main = heaviest.result.section
    return PhysicsSection(
        material=main.material,
        density_kgm3=_together(total.mass_kg / volume, [p.result.section.density_kgm3 for p in parts]),
        mass_kg=mass,
        centre_of_mass_m=_together(vec3(total.centre_of_mass_m), [p.result.section.centre_of_mass_m for p in parts]),
        inertia_kgm2=_together(matrix3(total.inertia_kgm2), [p.result.section.inertia_kgm2 for p in parts]),
        mass_parts=tuple(part for p in parts for part in p.result.section.mass_parts),
        contacts=main.contacts,
        collision_method=BY_LINK,
        candidates=(),
        collider_materials=tuple(
            c.model_copy(update={"collider": f"{p.link.name}/{c.collider}"})
            for p in parts
            for c in p.result.section.collider_materials
        ),
        joints=tuple(joint_evidence(joint) for joint in mechanism.joints),
        links=tuple(_link_section(p) for p in parts),
    )


def _together(value: Any, of_links: Sequence[Evidence[Any]], bounds: Any = None) -> Evidence[Any]:
    """Evidence for a value over all links: as weak as that of the weakest."""
    weakest = min(of_links, key=lambda e: e.confidence)
    method = f"{len(of_links)} links together, at rest"
    return Evidence(value=value, source=weakest.source, method=method, confidence=weakest.confidence, bounds=bounds)


def _link_section(part: _LinkPhysics) -> LinkSection:
    section = part.result.section
    return LinkSection(
        name=part.link.name,
        members=part.link.members,
        origin_m=vec3(part.link.origin),
        material=section.material,
        density_kgm3=section.density_kgm3,
        mass_kg=section.mass_kg,
        centre_of_mass_m=section.centre_of_mass_m,
        inertia_kgm2=section.inertia_kgm2,
        collision_method=section.collision_method,
        candidates=section.candidates,
    )


def joint_evidence(joint: MechanismJoint) -> Evidence[dict[str, Any]]:
    """The joint as the record has it: rad and m; what the source does not state is left out."""
    unit = "rad" if joint.is_angular else "m"
    value: dict[str, Any] = {
        "name": joint.name,
        "type": joint.kind,
        "parent": joint.parent,
        "child": joint.child,
        "axis": vec3(joint.axis),
        "anchor_m": vec3(joint.anchor),
        f"limits_{unit}": joint.limits,
        f"rest_{unit}": joint.rest,
    }
    numbers: Mapping[str, float | None] = {
        "effort": joint.effort,
        "velocity": joint.velocity,
        "damping": joint.damping or None,
        "friction": joint.friction or None,
        "armature": joint.armature or None,
        "stiffness": joint.stiffness or None,
        f"spring_rest_{unit}": joint.spring_rest if joint.stiffness else None,
    }
    value |= {key: number for key, number in numbers.items() if number is not None}
    if joint.coupling is not None:
        coupling = joint.coupling
        value["follows"] = {"joint": coupling.joint, "multiplier": coupling.multiplier, "offset": coupling.offset}
    if joint.closes_loop:
        value["closes_loop"] = True
    if joint.source_name not in ("", joint.name):
        value["source_name"] = joint.source_name
    where = (str(joint.where),) if joint.where is not None else ()
    if joint.limits_inferred:
        return inferred(
            value,
            "joint of the source; it states no limits: the way that is free, at most the size of the object",
            0.3,
            inputs=where,
        )
    return declared(value, "joint of the source", inputs=where)
