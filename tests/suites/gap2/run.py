"""`python -m tests.suites.gap2.run --start N --n M --resume DIR`: makes cases, runs the finder on folders, scores.

One JSON per case lies in the folder; what is there is not run again. The finder sees a folder named by a hash, in
which there is neither truth nor the case's name.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.suites.gap2.finder import find_in
from tests.suites.gap2.foreign import foreign_cases
from tests.suites.gap2.generate.cases import CaseFiles, family_of, mechanism_case, write_case
from tests.suites.gap2.generate.tosses.cases import toss_case, tumble_case
from tests.suites.gap2.generate.truth import FAMILIES, Truth
from tests.suites.gap2.score import line, scored_record, table

Record = dict[str, Any]
KINDS: dict[str, Callable[[int], CaseFiles]] = {"mechanism": mechanism_case, "toss": toss_case, "tumble": tumble_case}
_KEPT = ("verdict", "traps", "gains", "n_train", "n_test", "wall_s")


def run_number(kind: str, number: int) -> Record:
    """The record of a generated case: its truth, what the finder reports, and the processor time of each."""
    began = time.process_time()
    case = KINDS[kind](number)
    made_s = time.process_time() - began
    with tempfile.TemporaryDirectory() as scratch:
        return {**run_folder(write_case(case, Path(scratch)), case.truth), "made_s": round(made_s, 2)}


def run_foreign(folder: Path, truth: Truth) -> Record:
    """The same for somebody else's case, from a copy named by a hash."""
    name = hashlib.sha256((folder / "measurement.yaml").read_bytes()).hexdigest()[:16]
    with tempfile.TemporaryDirectory() as scratch:
        copied = Path(shutil.copytree(folder, Path(scratch) / name))
        return run_folder(copied, replace(truth, measurement=name))


def run_folder(folder: Path, truth: Truth) -> Record:
    """Runs the finder on a folder; of its report what the scorer and a reader need is kept."""
    began = time.process_time()
    report = find_in(folder, folder.parent / "out", truth.left_out)
    spent = time.process_time() - began
    judged = {k: v for k, v in report.items() if k in _KEPT or k == "refused"}
    return {"truth": truth.as_dict(), "report": judged, "cpu_s": round(spent, 2)}


def main() -> None:
    """Prints a line per case, then the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--n", type=int, default=20)
    parser.add_argument("--kind", choices=tuple(KINDS), default="mechanism")
    parser.add_argument("--family", choices=FAMILIES, help="only this family")
    parser.add_argument("--only", type=int, nargs="*", help="only these numbers")
    parser.add_argument("--jobs", type=int, default=1, help="cases at once")
    parser.add_argument("--resume", type=Path, required=True, help="folder of one record per case, read and filled")
    parser.add_argument("--score-foreign", type=Path, metavar="DIR", help="run somebody else's cases instead")
    asked = parser.parse_args()
    work = _foreign_work(asked) if asked.score_foreign is not None else _generated_work(asked)
    cases = []
    for record in _records(work, asked.jobs):
        cases.append(scored_record(record))
        print(f"{record['cpu_s']:6} s  {line(cases[-1])}", flush=True)
    print()
    print(table(cases))


Work = tuple[Path, Callable[..., Record], tuple[Any, ...]]  # the record's file, what makes it, from what


def _foreign_work(asked: argparse.Namespace) -> list[Work]:
    return [
        (asked.resume / f"foreign_{truth.number:04d}.json", run_foreign, (folder, truth))
        for folder, truth in foreign_cases(asked.score_foreign)
        if asked.family in (None, truth.family) and (not asked.only or truth.number in asked.only)
    ]


def _generated_work(asked: argparse.Namespace) -> list[Work]:
    return [
        (asked.resume / f"{asked.kind}_{number:05d}.json", run_number, (asked.kind, number))
        for number in asked.only or range(asked.start, asked.start + asked.n)
        if asked.family in (None, family_of(number))
    ]


def _records(work: Sequence[Work], jobs: int) -> Iterator[Record]:
    """Records in order, from their files or run now; each is written as soon as it is done."""
    todo = [w for w in work if not w[0].exists()]
    if jobs > 1 and len(todo) > 1:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, mp_context=context) as pool:
            list(pool.map(_run_into, todo))
        todo = []
    for item in work:
        if item in todo:
            _run_into(item)
        yield json.loads(item[0].read_text())


def _run_into(item: Work) -> None:
    file, run, arguments = item
    file.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(run(*arguments), indent=1) + "\n"
    partial = file.with_suffix(".partial")
    partial.write_text(text)
    partial.replace(file)


if __name__ == "__main__":
    main()
