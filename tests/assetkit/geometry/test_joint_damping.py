"""Damping that takes more than a strong person to move a joint is left out, with a finding and a repair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.geometry.joint_damping import MOST_N, SLOWLY_S, plausible_damping
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from tests.support.package_samples import box_mesh

DOOR = box_mesh((0.4, 0.02, 0.5), "door", (0.2, 0.0, 0.0), link="door")
ARM_M = float(np.hypot(0.4, 0.01))
HINGE = MechanismJoint("hinge", "revolute", "case", "door", np.zeros(3), np.array([0.0, 0.0, 1.0]), limits=(0.0, 2.0))
SLIDE = replace(HINGE, kind="prismatic", limits=(0.0, 0.4))


def mechanism(joint: MechanismJoint) -> Mechanism:
    return Mechanism((MechanismLink("case", np.zeros(3)), MechanismLink("door", np.zeros(3))), (joint,))


@pytest.mark.parametrize(
    ("joint", "bound"), [(HINGE, MOST_N * ARM_M * SLOWLY_S / 2.0), (SLIDE, MOST_N * SLOWLY_S / 0.4)]
)
def test_damping_up_to_the_bound_stays_and_beyond_it_is_left_out(joint: MechanismJoint, bound: float) -> None:
    good = plausible_damping(mechanism(replace(joint, damping=0.99 * bound)), [DOOR])
    assert good.mechanism.joints[0].damping == 0.99 * bound
    assert (good.diagnostics, good.repairs) == ((), ())
    bad = plausible_damping(mechanism(replace(joint, damping=1.01 * bound)), [DOOR])
    assert bad.mechanism.joints == (joint,)
    (note,) = bad.diagnostics
    assert note.code == "asset/joint-damping-implausible"
    assert note.value == pytest.approx(1.01 * MOST_N, rel=1e-6)
    assert [(r.name, r.before["damping"], r.after["damping"]) for r in bad.repairs] == [
        ("drop_damping", 1.01 * bound, 0.0)
    ]


def test_what_is_not_moved_by_the_joint_does_not_lengthen_its_arm() -> None:
    damping = 1.01 * MOST_N * ARM_M * SLOWLY_S / 2.0
    case = box_mesh((5.0, 5.0, 5.0), "case", link="case")
    assert plausible_damping(mechanism(replace(HINGE, damping=damping)), [case, DOOR]).repairs
