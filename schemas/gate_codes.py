"""Codes of the static gate (`usdio.gate`), one per rule; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.code_info import CodeInfo

GATE_CODES: dict[str, CodeInfo] = {
    "asset/gate-units": CodeInfo(
        "error",
        "The package is not in metres, kilograms and z-up",
        "Simulators read the numbers as they stand; other units make every length and mass wrong.",
        "set metersPerUnit and kilogramsPerUnit to 1 and upAxis to Z, and convert the values",
    ),
    "asset/gate-default-prim": CodeInfo(
        "error",
        "The package has no single, placeable component as its default prim",
        "Referencing the file would bring in nothing, or less than the asset.",
        "put everything under one Xform, make it the default prim with kind component",
    ),
    "asset/gate-missing-file": CodeInfo(
        "error",
        "A file the package names is absent",
        "The surface loses its picture on every machine but, at best, one.",
        "put the file into the package and name it by a relative path",
    ),
    "asset/gate-extent": CodeInfo(
        "error",
        "The visible size is impossible or differs from the stated one",
        "Scenes are laid out by the stated size.",
        "correct the scale, or state the size the asset has",
    ),
    "asset/gate-body-scale": CodeInfo(
        "error",
        "A rigid body is scaled, sheared or mirrored",
        "Engines drop, bake or misread the scale of a body, each in its own way.",
        "apply the scale to the points and leave the body at scale 1",
    ),
    "asset/gate-mass": CodeInfo(
        "error",
        "A body has no positive mass",
        "Engines then invent one (often 1 kg) or refuse the body.",
        "author physics:mass in kilograms",
    ),
    "asset/gate-density": CodeInfo(
        "error",
        "Mass and volume give a density no material has",
        "The object would push like lead or float like smoke.",
        "check the mass, the scale and the colliders against each other",
    ),
    "asset/gate-inertia": CodeInfo(
        "error",
        "The moments of inertia belong to no real body",
        "Engines become unstable or replace the tensor by their own.",
        "recompute the principal moments and axes from the solid",
    ),
    "asset/gate-inertia-scale": CodeInfo(
        "error",
        "The inertia does not fit mass and size",
        "The object would spin far too easily or hardly at all.",
        "recompute the inertia in kg m2 about the mass centre",
    ),
    "asset/gate-mass-centre-outside": CodeInfo(
        "error",
        "The mass centre lies outside the colliders",
        "The object would topple or balance in ways its shape forbids.",
        "check the frame of physics:centerOfMass: it is the body's own",
    ),
    "asset/gate-no-collider": CodeInfo(
        "error",
        "A moving body has no collider",
        "It falls through everything.",
        "add collision shapes below the body",
    ),
    "asset/gate-collider-not-convex": CodeInfo(
        "error",
        "A moving mesh collider is not convex",
        "Engines refuse concave moving meshes or let them fall through the floor.",
        "decompose the mesh and set physics:approximation to convexHull",
    ),
    "asset/gate-collider-displaced": CodeInfo(
        "error",
        "Colliders and visible surface have different bounds",
        "Contacts would happen where nothing is seen.",
        "check the transforms of the colliders",
    ),
    "asset/gate-friction": CodeInfo(
        "error",
        "A contact material is absent or its friction impossible",
        "Static friction below dynamic, or below zero, gives jitter or is ignored.",
        "bind a physics material with static >= dynamic >= 0 to every collider",
    ),
    "asset/gate-restitution": CodeInfo(
        "error",
        "Restitution lies outside 0 to 1",
        "Above 1 every bounce adds energy; below 0 is undefined.",
        "set physics:restitution between 0 and 1",
    ),
    "asset/gate-joint-limits": CodeInfo(
        "error",
        "The lower limit of a joint is above the upper one",
        "The joint locks, or moves freely, depending on the engine.",
        "swap the limits",
    ),
}
