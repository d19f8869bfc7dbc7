"""Detection of defects seeded into clean packages, by the gate and by external validators.

    python -m benchmarks.gate.seeded_defects [--only WORD]

Every defect of `tests/suites/gate` is put alone into a copy of a clean package (a textured prop, a cabinet with drawer
and door). A validator has caught it when it reports a finding that it does not report on the clean package; SimReady's
optional features, whose failures do not block, count separately. Prints one line per defect, then totals, then the
number of findings on the clean packages.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from pathlib import Path

from gate.external_validators import simready, simready_optional, usd_validation
from gate.static_gate import gate
from tests.suites.gate import DEFECTS
from tests.support.gate_packages import cabinet, prop, seeded

COLUMNS = ("gate", "its rule", "simready", "optional", "usd-val.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="defects whose name or code holds this word")
    only = parser.parse_args().only
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        files = {"prop": prop(work / "clean"), "cabinet": cabinet(work / "clean")}
        clean = {name: findings_by_validator(file) for name, file in files.items()}
        print(f"{'defect':42} {'expected':24} " + " ".join(f"{c:>8}" for c in COLUMNS))
        totals: Counter[str] = Counter()
        chosen = [d for d in DEFECTS if only in d.name or only in d.code]
        for defect in chosen:
            seeded_findings = findings_by_validator(seeded(defect.edit, files[defect.package], work / "seeded"))
            marks = {
                validator: bool(lines - clean[defect.package][validator])
                for validator, lines in seeded_findings.items()
            }
            marks["its rule"] = any(
                line.startswith(f"{defect.severity} {defect.code} ") for line in seeded_findings["gate"]
            )
            totals.update(validator for validator, mark in marks.items() if mark)
            shown = " ".join(f"{'x' if marks[c] else '-':>8}" for c in COLUMNS)
            print(f"{defect.name:42} {defect.code.removeprefix('asset/gate-'):24} {shown}")
        print(f"{'caught of ' + str(len(chosen)):67} " + " ".join(f"{totals[c]:8}" for c in COLUMNS))
        for name, findings in clean.items():
            counts = ", ".join(
                f"{validator} {len(lines)}" for validator, lines in findings.items() if validator != "optional"
            )
            print(f"findings on the clean {name}: {counts}")


def findings_by_validator(file: Path) -> dict[str, set[str]]:
    """Validator -> its findings as lines, warnings included."""
    usd = usd_validation(file)
    return {
        "gate": {f"{d.severity} {d.code} {d.headline} {d.where}" for d in gate(file)},
        "simready": {str(remark) for remark in simready(file).findings},
        "optional": {str(remark) for remark in simready_optional(file)},
        "usd-val.": {str(remark) for remark in (*usd.findings, *usd.warnings)},
    }


if __name__ == "__main__":
    main()
