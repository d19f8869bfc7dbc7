"""Seeded defects of packages: each breaks one thing in a clean package and names the gate rule that must report it.

`test_defects.py` proves that the gate reports each; `benchmarks/gate/seeded_defects.py` also runs the external
validators on them. Read `edits.py` first.
"""

from tests.suites.gate.defects import DEFECTS
from tests.suites.gate.edits import Defect

__all__ = ["DEFECTS", "Defect"]
