"""`python -m tests.suites.pipeline_faults.run --sites 10`: injects every kind of mistake, prints what was noticed."""

from __future__ import annotations

import argparse
import random
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from dsl.pipeline_file import read_pipeline
from schemas.diagnostics import Diagnostic, any_error
from tests.suites.pipeline_faults.faults import Fault, Inject, kinds
from tests.suites.pipeline_faults.programs import program

PROGRAMS = 40
SEED = 20261127


@dataclass(frozen=True)
class Outcome:
    """One injected mistake: whether an error was reported, and whether one at its line."""

    kind: str
    noticed: bool
    at_line: bool
    text: str
    findings: tuple[Diagnostic, ...]


def checked(text: str, folder: Path) -> tuple[Diagnostic, ...]:
    """The findings of a pipeline."""
    file = folder / "pipeline.yaml"
    file.write_text(text)
    return read_pipeline(file)[1]


def sites(kind: str, inject: Inject, count: int, seed: int) -> Iterator[Fault]:
    """So many mistakes of a kind, over programs in a random order."""
    rng = random.Random(f"{kind} {seed}")
    candidates: list[Fault] = []
    for number in rng.sample(range(PROGRAMS), PROGRAMS):
        here = list(inject(program(number).split("\n")))
        if here:
            candidates.append(rng.choice(here))
        if len(candidates) == count:
            break
    yield from candidates


def outcomes(count: int, folder: Path, seed: int = SEED) -> Iterator[Outcome]:
    """Every kind at so many sites."""
    for kind, inject in kinds().items():
        for fault in sites(kind, inject, count, seed):
            findings = checked(fault.text, folder)
            errors = [each for each in findings if any_error([each])]
            shown = {at.line for each in errors for at in (each.where, *(label.where for label in each.labels))}
            at_line = fault.line in shown
            yield Outcome(kind, bool(errors), at_line, fault.text, findings)


def main() -> None:
    """Prints kinds that were missed or shown elsewhere, then the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sites", type=int, default=10)
    parser.add_argument("--seed", type=int, default=SEED)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        false = sum(any_error(checked(program(number), folder)) for number in range(PROGRAMS))
        rows = list(outcomes(asked.sites, folder, asked.seed))
    for row in rows:
        if not row.at_line:
            words = "; ".join(f"{each.where}: {each.headline}" for each in row.findings) or "nothing"
            print(f"{row.kind}: {'shown elsewhere' if row.noticed else 'MISSED'}: {words}")
    noticed, at_line = sum(row.noticed for row in rows), sum(row.at_line for row in rows)
    print(
        f"{len(kinds())} kinds, {len(rows)} mistakes: {noticed} noticed ({100 * noticed / len(rows):.1f} %), ", end=""
    )
    print(f"{at_line} at their line ({100 * at_line / len(rows):.1f} %); {false} of {PROGRAMS} valid pipelines refused")


if __name__ == "__main__":
    main()
