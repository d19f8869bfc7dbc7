"""Damages packages of a library, each kind on several of them, and counts what acceptance makes of them.

    python -m tests.suites.sabotage.run LIBRARY... --seed 1 --each 5 --resume OUT

Controls come first: packages as released, without those in review; each that `mana assets accept` fails is counted.
Every kind is then tried on packages drawn by seed among the controls that pass and that it can damage. One JSON line
per case in OUT/cases.jsonl; a run continues where it stopped.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from assetkit.library.accept import accept_files
from assetkit.library.acceptance_request import AcceptanceReport, AcceptanceRequest
from assetkit.library.validate import main_usd_files
from cli.engines import SIMULATOR
from schemas.diagnostics import Diagnostic
from tests.suites.sabotage.package import victim
from tests.suites.sabotage.table import MECHANISMS, RIGID, Kind

CONTROL = "control"


def main() -> None:
    """Run what is not in OUT yet, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("libraries", type=Path, nargs="+")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--each", type=int, default=5)
    parser.add_argument("--controls", type=int, default=40)
    parser.add_argument("--resume", type=Path, required=True)
    arguments = parser.parse_args()
    log = arguments.resume / "cases.jsonl"
    arguments.resume.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    packages = [p.parent for library in arguments.libraries for p in sorted(library.glob("*/record.json")) if _clean(p)]
    with log.open("a") as file:
        for row in cases(packages, rows, arguments.seed, arguments.each, arguments.controls):
            rows.append(row)
            file.write(json.dumps(row) + "\n")
            file.flush()
            print(row["kind"], row["package"], row["outcome"], *row["codes"], flush=True)
    print_table(rows)


def cases(
    packages: Sequence[Path], done: Sequence[dict[str, Any]], seed: int, each: int, controls: int
) -> Iterator[dict[str, Any]]:
    """Rows of controls first, then of every kind on sound packages, without those in `done`."""
    random = np.random.default_rng(seed)
    ready = {(row["kind"], row["package"]): row for row in done}
    shuffled = [packages[i] for i in random.permutation(len(packages))]
    sound: list[Path] = []
    for package in shuffled:
        row = ready.get((CONTROL, package.name)) or _case(package, None, seed)
        assert row is not None
        if (CONTROL, package.name) not in ready:
            yield row
        sound += [package] if row["outcome"] == "passed" else []
        if len(sound) >= controls:
            break
    for kind in (*RIGID, *MECHANISMS):
        count = sum(1 for name, _ in ready if name == kind.name)
        for package in [sound[i] for i in random.permutation(len(sound))]:
            if count >= each:
                break
            if (kind.name, package.name) in ready or _is_articulated(package) != (kind in MECHANISMS):
                continue
            row = _case(package, kind, seed)
            if row is not None:
                count += 1
                yield row


def _clean(record: Path) -> bool:
    """Whether a package was released without a question to a person."""
    return json.loads(record.read_text())["outcome"] in ("accepted", "repaired")


def _is_articulated(package: Path) -> bool:
    return bool(json.loads((package / "record.json").read_text())["physics"]["joints"])


def _case(package: Path, kind: Kind | None, seed: int) -> dict[str, Any] | None:
    """The row of one package, damaged or not; None where the kind has nothing to damage there."""
    with tempfile.TemporaryDirectory(prefix="sabotage") as folder:
        if kind is None:
            copy = Path(folder) / package.name
            shutil.copytree(package, copy)
        else:
            damaged = victim(package, Path(folder), _seed(seed, kind.name, package.name))
            if not kind.damage(damaged):
                return None
            damaged.save()
            copy = damaged.folder
        request = AcceptanceRequest(main_file=str(main_usd_files(copy)[0]), engine=SIMULATOR, thorough=False)
        ((_, report),) = accept_files([request])
    return _row(package, kind, report)


def _row(package: Path, kind: Kind | None, report: AcceptanceReport) -> dict[str, Any]:
    codes = sorted({d.code for finding in report.findings for d in _with_causes(finding)})
    row: dict[str, Any] = {
        "kind": CONTROL if kind is None else kind.name,
        "package": package.name,
        "outcome": "passed" if report.passed else "failed",
        "failed": [suite.name for suite in report.suites if suite.outcome == "failed"],
        "codes": codes,
    }
    if kind is not None:
        row["attributed"] = not report.passed and bool(kind.codes & set(codes))
    return row


def _with_causes(finding: Diagnostic) -> Iterator[Diagnostic]:
    yield finding
    for cause in finding.because:
        yield from _with_causes(cause)


def _seed(seed: int, kind: str, package: str) -> int:
    return int.from_bytes(hashlib.sha256(f"{seed}/{kind}/{package}".encode()).digest()[:4], "little")


def print_table(rows: Sequence[dict[str, Any]]) -> None:
    """Per kind: cases, noticed, attributed; then all together."""
    damaged = [row for row in rows if row["kind"] != CONTROL]
    for kind in dict.fromkeys(row["kind"] for row in damaged):
        of_kind = [row for row in damaged if row["kind"] == kind]
        noticed = sum(row["outcome"] == "failed" for row in of_kind)
        attributed = sum(row["attributed"] for row in of_kind)
        codes = Counter(code for row in of_kind for code in row["codes"])
        seen = ", ".join(code.removeprefix("asset/") for code, _ in codes.most_common(4))
        print(f"{kind:24} {len(of_kind):3} noticed {noticed:3} attributed {attributed:3}   {seen}")
    attributed = sum(row["attributed"] for row in damaged)
    print(f"attributed {attributed} of {len(damaged)} = {attributed / max(len(damaged), 1):.1%}")
    controls = [row for row in rows if row["kind"] == CONTROL]
    failed = [row["package"] for row in controls if row["outcome"] != "passed"]
    print(f"controls: {len(failed)} of {len(controls)} fail {failed}")


if __name__ == "__main__":
    main()
