"""Numbers for a package or URDF from an extension, in the asset's frame; for the effects left out, the reason."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.asset import Matrix3, PhysicsSection, Vec3, matrix3, vec3
from schemas.diagnostics import InvalidInput, finding
from schemas.evidence import Evidence, measured
from schemas.measured_physics import MeasuredJoint, MeasuredPhysics
from schemas.sim_gap.extension import AppliedEffect, Estimate, ModelExtension
from sim.effects.effect import PackageField
from sim.effects.library import effect

CONFIDENCE = 0.95  # that of the interval
_RELATIVE = ("inertia_kgm2", "centre_of_mass_m")  # fields whose effects are relative to the declared body
_ELSEWHERE = {
    "world": "it belongs to the surroundings, not to the asset",
    "actuator": "it belongs to the drive, not to a rigid body",
    "sensor": "it belongs to the sensor, not to the asset",
    "robot": "it belongs to the controller, not to a rigid body",
    "joint": "the package is one rigid body without joints; give the URDF of the mechanism instead",
    "body": "neither USD nor URDF has an attribute for it",
    "contact": "neither USD nor URDF has an attribute for it",
}


@dataclass(frozen=True)
class MeasuredBody:
    """How the measurement declares the body: what relative values are relative to.

    p_AB             (3,) origin of the measured body frame B in the asset frame A; axes are parallel.
    inertia_per_kg   (3, 3) declared inertia about the mass centre over declared mass.
    """

    p_AB: FloatArray
    inertia_per_kg: FloatArray


@dataclass(frozen=True)
class Row:
    """One effect and what became of it: the places it was written to, or why it was not."""

    effect: str
    where: str
    values: dict[str, Estimate]
    written: tuple[str, ...] = ()
    why: str = ""


def package_physics(
    extension: ModelExtension, extension_json: bytes, section: PhysicsSection, body: MeasuredBody | None, reason: str
) -> tuple[MeasuredPhysics, tuple[Row, ...]]:
    """The numbers for a package with this physics, and a row per effect.

    Mass centre and inertia are relative to the body as the measurement declares it; without `body` they are left out
    for the `reason` given. Inertia is written per kilogram of the package, because motion alone shows no mass. Raises
    InvalidInput for values that the effect does not allow.
    """
    fields: dict[str, Evidence] = {}
    contact: dict[str, float] = {}
    rows: list[Row] = []
    mass_kg = _mass_kg(extension.effects, section)
    by_name = _by_name(extension.effects)
    for applied in extension.effects:
        known, method = effect(applied.name), _method(applied, extension)
        key, tags = known.export.package, known.export.urdf_contact
        if by_name[applied.name] is not applied:
            rows.append(_kept(applied, "the package holds one value, that of the first place"))
        elif key in _RELATIVE and body is None:
            rows.append(_kept(applied, reason))
        elif key is not None:
            fields[key] = _evidence(key, applied, mass_kg, body, method)
            rows.append(_written(applied))
        elif tags:
            contact |= {tag: applied.parameters[p].value for p, tag in tags.items()}
            written = tuple(f"URDF contact/{tag}" for tag in tags.values())
            rows.append(Row(applied.name, str(applied.where), applied.parameters, written))
        else:
            rows.append(_kept(applied, known.export.left_out or _ELSEWHERE[known.family]))
    return MeasuredPhysics(extension_json=extension_json, urdf_contact=contact, **fields), tuple(rows)


def joint_physics(extension: ModelExtension) -> tuple[dict[str, MeasuredJoint], tuple[Row, ...]]:
    """Numbers for the joints of a URDF by name, and a row per effect."""
    joints: dict[str, dict[str, Estimate]] = {}
    rows: list[Row] = []
    for applied in extension.effects:
        joint, known = applied.where.joint, effect(applied.name)
        exported = {
            name: applied.parameters[p]
            for p, name in known.export.urdf_joint.items()
            if applied.parameters[p].value >= known.export.urdf_least
            and (_reached(applied.parameters[p]) or not known.export.only_reached)
        }
        if joint is None or not exported:
            family = known.family
            elsewhere = "URDF has no attribute for it" if family in ("joint", "actuator") else _ELSEWHERE[family]
            why = "a body's numbers go into its package" if family in ("body", "contact") else elsewhere
            rows.append(_kept(applied, why))
            continue
        joints.setdefault(joint, {}).update(exported)
        rows.append(Row(applied.name, joint, applied.parameters, (f"URDF {known.export.urdf}",)))
    return {name: MeasuredJoint(**{k: v.value for k, v in values.items()}) for name, values in joints.items()}, tuple(
        rows
    )


def refuse_impossible(extension: ModelExtension) -> None:
    """Raises InvalidInput (`gap/invalid-extension`) for a value outside what its effect allows."""
    for applied in extension.effects:
        for parameter in effect(applied.name).parameters:
            value = applied.parameters[parameter.name].value
            if not parameter.low <= value <= parameter.high:
                headline = f"{applied.name}: {parameter.name} is outside {parameter.low:g} .. {parameter.high:g}"
                raise InvalidInput(finding("gap/invalid-extension", headline, value=value, unit=parameter.unit))


def _by_name(effects: Iterable[AppliedEffect]) -> dict[str, AppliedEffect]:
    """The first of each name."""
    first: dict[str, AppliedEffect] = {}
    for applied in effects:
        first.setdefault(applied.name, applied)
    return first


def _mass_kg(effects: Iterable[AppliedEffect], section: PhysicsSection) -> float:
    """Mass of the package with the effects."""
    measured_kg = [a.parameters["mass_kg"].value for a in effects if effect(a.name).export.package == "mass_kg"]
    return measured_kg[0] if measured_kg else section.mass_kg.value


def _evidence(
    key: PackageField, applied: AppliedEffect, mass_kg: float, body: MeasuredBody | None, method: str
) -> Evidence:
    """The value of a field of the package."""
    if key == "inertia_kgm2" and body is not None:
        return _inertia(applied.parameters["factor"], body.inertia_per_kg * mass_kg, method)
    if key == "centre_of_mass_m" and body is not None:
        return _centre(applied, body.p_AB, method)
    (value,) = applied.parameters.values()
    return measured(value.value, method, confidence=CONFIDENCE, bounds=value.ci95)


def _method(applied: AppliedEffect, extension: ModelExtension) -> str:
    return f"{applied.name}, 95 % interval, from measurement {extension.measurement[:12]}"


def _inertia(factor: Estimate, tensor: FloatArray, method: str) -> Evidence[Matrix3]:
    ends = np.stack([tensor * f for f in factor.ci95])
    bounds = (matrix3(ends.min(axis=0)), matrix3(ends.max(axis=0)))
    return measured(matrix3(tensor * factor.value), method, confidence=CONFIDENCE, bounds=bounds)


def _centre(applied: AppliedEffect, p_AB: FloatArray, method: str) -> Evidence[Vec3]:
    axes = [applied.parameters[k] for k in ("x_m", "y_m", "z_m")]
    low, high = (vec3(p_AB + np.array([e.ci95[k] for e in axes])) for k in (0, 1))
    value = vec3(p_AB + np.array([e.value for e in axes]))
    return measured(value, method, confidence=CONFIDENCE, bounds=(low, high))


def _written(applied: AppliedEffect) -> Row:
    known = effect(applied.name)
    return Row(
        applied.name, str(applied.where), applied.parameters, (f"USD {known.export.usd}", f"URDF {known.export.urdf}")
    )


def _kept(applied: AppliedEffect, why: str) -> Row:
    return Row(applied.name, str(applied.where), applied.parameters, why=why)


def _reached(stop: Estimate) -> bool:
    """Whether the trials came to this end of travel: where none did, no value was found, and it has no interval."""
    return stop.ci95[0] < stop.ci95[1]
