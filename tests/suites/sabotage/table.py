"""Kinds of sabotage and the codes that must name each: written before the run, from what each damage breaks.

A package is attributed where at least one expected code is among the findings of `mana assets accept`. The twin
(`asset/gate-twin`, `asset/twin-disagrees`), the comparison with figures of the record (`asset/gate-record`) and hashes
notice most edits of physics and count for nothing here. What a damage breaks depends on the roles: an object that tips
over loses what is on it if it is a support, spills if it is a receptacle, and in any case does not stay in its poses.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from tests.suites.sabotage import mechanisms, rigid
from tests.suites.sabotage.package import Victim


class Kind(NamedTuple):
    """One kind of damage, and the codes of which one must be found."""

    damage: Callable[[Victim], bool]
    codes: frozenset[str]

    @property
    def name(self) -> str:
        """That of the function."""
        return self.damage.__name__


def _codes(*names: str) -> frozenset[str]:
    return frozenset(f"asset/{name}" for name in names)


TIPS = ("stable-pose-lost", "receptacle-leaves", "receptacle-spill", "receptacle-tips", "support-stack", "support-tips")
PLACES = ("anchor-lost", "receptacle-leaves", "receptacle-spill", "receptacle-tunnel")
MISALIGNED = ("render-collision-misaligned", "gate-collider-displaced", "gate-collider-astray")

RIGID = (
    Kind(rigid.heavy, _codes("handling-lost", "handling-slip", "gate-density", "gate-mass", "tool-lost",
                              "mass-beyond-bounds")),
    Kind(rigid.light, _codes("gate-density", "gate-mass", "mass-beyond-bounds")),
    Kind(rigid.slippery, _codes("handling-lost", "handling-slip", "tool-lost")),
    Kind(rigid.mass_centre_aside, _codes("handling-lost", "handling-slip", "handling-landing", "settling-unrepeatable",
                                         "tool-lost", "tool-slip", "gate-mass-centre-far", "gate-inertia-reach",
                                         *TIPS)),
    Kind(rigid.mass_centre_outside, _codes("package-invalid", "gate-mass-centre-outside")),
    Kind(rigid.wild_inertia, _codes("package-invalid", "gate-inertia-reach", "gate-inertia-scale")),
    Kind(rigid.impossible_inertia, _codes("package-invalid", "gate-inertia")),
    Kind(rigid.colliders_moved, _codes(*MISALIGNED)),
    Kind(rigid.colliders_grown, _codes(*MISALIGNED)),
    Kind(rigid.inside_out, _codes("package-invalid", "gate-collider-not-convex", "gate-collider-shape")),
    Kind(rigid.dented, _codes("package-invalid", "gate-collider-not-convex")),
    Kind(rigid.half_missing, _codes("render-collision-misaligned", "gate-collider-incomplete")),
    Kind(rigid.cavity_filled, _codes("gate-collider-cavity", *PLACES)),
    Kind(rigid.floor_missing, _codes("gate-collider-incomplete", "gate-collider-cavity", *PLACES)),
    Kind(rigid.floor_thinned, _codes("receptacle-tunnel", "gate-collider-shape", "gate-collider-incomplete",
                                     "render-collision-misaligned", "gate-collider-cavity", "anchor-lost")),
    Kind(rigid.anchor_raised, _codes("support-stack", "support-tips", *PLACES)),
    Kind(rigid.bump_on_support, _codes("support-stack", "anchor-lost")),
    Kind(rigid.foot_ridge, _codes("settling-unrepeatable", "unstable-settling", "handling-landing", *TIPS,
                                  *MISALIGNED)),
    Kind(rigid.grasp_aside, _codes("handling-lost")),
    Kind(rigid.grasp_narrow, _codes("handling-pushed", "handling-lost")),
    Kind(rigid.grasp_weak, _codes("handling-lost", "handling-slip")),
    Kind(rigid.no_contact_material, _codes("package-invalid", "gate-contact-material")),
    Kind(rigid.friction_reversed, _codes("gate-friction")),
    Kind(rigid.wrong_extent, _codes("package-invalid", "gate-extent", "gate-record")),
    Kind(rigid.wrong_pose, _codes("handling-lost", "handling-pushed", "handling-landing", "handling-slip",
                                  "stable-pose-lost")),
)  # fmt: skip
MECHANISMS = (
    Kind(mechanisms.limits_swapped, _codes("gate-joint-limits", "package-invalid")),
    Kind(mechanisms.limits_widened, _codes("joint-overruns-limit", "joint-penetration", "joint-blocked",
                                           "gate-joint-range", "joint-stuck")),
    Kind(mechanisms.limits_narrowed, _codes("handle-not-opened", "joint-stuck")),
    Kind(mechanisms.joint_jammed, _codes("joint-stuck", "handle-not-opened", "handle-forced", "gate-drive")),
    Kind(mechanisms.axis_reversed, _codes("handle-astray", "handle-not-opened", "joint-contact-astray",
                                          "joint-axis-astray", "joint-penetration", "joint-stuck")),
    Kind(mechanisms.axis_tilted, _codes("handle-astray", "handle-not-opened", "joint-axis-astray", "joint-penetration",
                                        "joint-stuck", "joint-blocked")),
    Kind(mechanisms.frames_apart, _codes("gate-joint-frames")),
    Kind(mechanisms.link_blocked, _codes("links-interpenetrate", "joint-penetration", "gate-links-overlap",
                                         "joint-stuck", "gate-collider-astray", "gate-collider-displaced")),
    Kind(mechanisms.link_without_collider, _codes("gate-no-collider", "gate-collider-incomplete", "package-invalid",
                                                  "render-collision-misaligned", "handle-not-taken")),
    Kind(mechanisms.link_grown, _codes("links-interpenetrate", "gate-links-overlap", "joint-penetration", "joint-stuck",
                                       *MISALIGNED)),
    Kind(mechanisms.link_heavy, _codes("package-invalid", "gate-inertia-reach", "gate-inertia-scale", "joint-stuck")),
    Kind(mechanisms.handle_missing, _codes("joint-contact-astray", "handle-not-taken", "gate-collider-incomplete",
                                           "render-collision-misaligned")),
    Kind(mechanisms.contact_behind, _codes("joint-contact-astray", "handle-not-taken", "handle-astray",
                                           "handle-not-opened")),
    Kind(mechanisms.root_missing, _codes("gate-articulation")),
    Kind(mechanisms.drive_wild, _codes("gate-drive")),
    Kind(mechanisms.body_doubled, _codes("gate-joint-bodies", "package-invalid")),
)  # fmt: skip
