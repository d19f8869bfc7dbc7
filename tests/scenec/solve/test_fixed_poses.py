"""Things that take fixed poses take the same ones in every process: Python's hash seed chooses nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
SEEDS = ("0", "1", "2", "3")
PLACES = """
import sys
from pathlib import Path
from scenec import compile_program
compiled = compile_program(Path(sys.argv[1]))
for problem, result in zip(compiled.problems, compiled.results):
    print({name: (p.x_m, p.y_m) for name, p in sorted(result.placements.items())})
"""


def test_the_matching_does_not_depend_on_the_hash_seed(tmp_path: Path) -> None:
    program = ROOT / "examples" / "scenes" / "rack_slots.yaml"
    answers = set()
    for seed in SEEDS:
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", PLACES, str(program)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        answers.add(done.stdout)
    assert len(answers) == 1
    assert "tube_c" in answers.pop()
