"""Seeded defects: each breaks one thing in a clean package and names the rule that must speak.

`tests/suites/gate/test_defects.py` proves that the gate sees each; `benchmarks/gate/seeded_defects.py` also asks
outside
validators.
"""

from tests.suites.gate import of_bodies, of_colliders, of_file, of_joints, of_looks
from tests.suites.gate.edits import Defect

DEFECTS: tuple[Defect, ...] = (
    *of_file.DEFECTS,
    *of_bodies.DEFECTS,
    *of_colliders.DEFECTS,
    *of_joints.DEFECTS,
    *of_looks.DEFECTS,
)
