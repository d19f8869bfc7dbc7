"""Seeded defects of packages: each breaks one thing in a clean package and names the gate rule that must report it;
and sound edits, which no rule may report.

`test_defects.py` proves that the gate reports each; `benchmarks/gate/seeded_defects.py` also runs the external
validators on them. Read `edits.py` first.
"""

from tests.suites.gate.defects import DEFECTS, SOUND
from tests.suites.gate.edits import Defect, Sound

__all__ = ["DEFECTS", "SOUND", "Defect", "Sound"]
