"""The static gate: runs all plausibility rules, in order, on the main USD file of an asset.

The rules cover what external validators do not; read `gate` and `RULES` first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pxr import Tf

from gate.rules.asset import (
    category_size,
    default_prim,
    extent,
    files,
    label,
    metadata,
    nonfinite_value,
    origin,
    outside_file,
    physics_scene,
    record,
    record_file,
    time_samples,
    twin,
    units,
    unknown_token,
)
from gate.rules.body import (
    body_flags,
    body_scale,
    density,
    density_stated,
    inertia,
    inertia_reach,
    inertia_scale,
    mass,
    mass_centre,
    mass_centre_far,
    mass_twice,
    nested_body,
    transform,
    velocity,
)
from gate.rules.collider import (
    collider_astray,
    collider_cavity,
    collider_convex,
    collider_displaced,
    collider_incomplete,
    collider_present,
    collider_rendered,
    collider_shape,
    collision_offset,
    contact_material,
    dangling_target,
    friction,
    restitution,
)
from gate.rules.joint import (
    articulation,
    drive,
    joint_anchor,
    joint_axis,
    joint_bodies,
    joint_flags,
    joint_frames,
    joint_limits,
    joint_motion,
    joint_range,
    joint_rest,
    links_overlap,
)
from gate.rules.rule import Rule
from gate.rules.visual import (
    inverted_mesh,
    material_binding,
    mesh_extent,
    mesh_topology,
    mesh_values,
    normals,
    not_visible,
    open_mesh,
    shader_network,
    shader_node,
    shader_value,
    texture_coordinates,
    texture_image,
    texture_reader,
    texture_space,
)
from gate.subject import Subject
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from usdio.quiet import quiet
from usdio.stage import open_stage

RULES: tuple[Rule, ...] = (
    # the file as a whole
    units.RULE,
    default_prim.RULE,
    files.RULE,
    outside_file.RULE,
    physics_scene.RULE,
    time_samples.RULE,
    unknown_token.RULE,
    extent.RULE,
    category_size.RULE,
    origin.RULE,
    label.RULE,
    metadata.RULE,
    record.RULE,
    record_file.RULE,
    twin.RULE,
    # bodies
    transform.RULE,
    body_scale.RULE,
    nested_body.RULE,
    body_flags.RULE,
    velocity.RULE,
    mass.RULE,
    mass_twice.RULE,
    density.RULE,
    density_stated.RULE,
    inertia.RULE,
    inertia_reach.RULE,
    inertia_scale.RULE,
    mass_centre.RULE,
    mass_centre_far.RULE,
    # colliders and contact
    collider_present.RULE,
    collider_convex.RULE,
    collider_shape.RULE,
    collider_displaced.RULE,
    collider_incomplete.RULE,
    collider_cavity.RULE,
    collider_astray.RULE,
    collider_rendered.RULE,
    collision_offset.RULE,
    contact_material.RULE,
    friction.RULE,
    restitution.RULE,
    dangling_target.RULE,
    # joints
    joint_bodies.RULE,
    joint_axis.RULE,
    joint_limits.RULE,
    joint_range.RULE,
    joint_frames.RULE,
    joint_rest.RULE,
    joint_anchor.RULE,
    joint_flags.RULE,
    drive.RULE,
    articulation.RULE,
    links_overlap.RULE,
    joint_motion.RULE,
    # visible surfaces and materials
    not_visible.RULE,
    mesh_topology.RULE,
    mesh_values.RULE,
    mesh_extent.RULE,
    normals.RULE,
    inverted_mesh.RULE,
    open_mesh.RULE,
    material_binding.RULE,
    shader_network.RULE,
    shader_node.RULE,
    shader_value.RULE,
    texture_reader.RULE,
    texture_space.RULE,
    texture_coordinates.RULE,
    texture_image.RULE,
    nonfinite_value.RULE,
)


def gate(main_file: Path) -> tuple[Diagnostic, ...]:
    """Every finding of every rule on the asset with this main file, in rule order; empty means passed.

    An error is wrong in any file, or in a package that claims to be SimReady; a warning is suspicious; `info` lists
    what keeps a file that claims nothing from being such a package. A file that cannot be opened gives the one finding
    `asset/package-invalid`.
    """
    with quiet():
        try:
            subject = Subject(open_stage(main_file), main_file)
        except InvalidInput as error:
            return (error.diagnostic,)
        with np.errstate(all="ignore"):  # Broken files hold infinities; comparisons are written so that NaN fails them.
            findings = (diagnostic for rule in RULES for diagnostic in _findings(rule, subject))
            return tuple({diagnostic.model_dump_json(): diagnostic for diagnostic in findings}.values())


def claims_release(main_file: Path) -> bool:
    """True iff the asset claims to be a SimReady package: by its metadata, or by a record.json beside its USD folder.

    Raises InvalidInput (`asset/package-invalid`) when the file cannot be opened.
    """
    with quiet():
        return Subject(open_stage(main_file), main_file).released


def _findings(rule: Rule, subject: Subject) -> tuple[Diagnostic, ...]:
    """The findings of one rule. A value that OpenUSD refuses to read, or an error of the rule, becomes a finding."""
    try:
        return tuple(rule.check(subject))
    except Tf.ErrorException as error:
        reason = str(error.args[0] if error.args else error).rpartition(" : ")[2].strip("' \n")
        return (finding("asset/package-invalid", "OpenUSD refuses a value in the file", value=reason[:300]),)
    except Exception as error:  # An error of one rule on an unforeseen file must not hide the findings of the others.
        value = f"{type(error).__name__}: {error}"[:300]
        return (finding("asset/internal-error", f"the rule {rule.code.name} failed", value=value),)
