"""What targeted repairs recover, and at what cost: sources as they are, and with physics damaged at the first attempt.

    python -m benchmarks.assets.repairs SOURCE... --out OUT [--damage filled] [--damage slippery] ...

Each source is ingested in this process without stored results. Under a damage the physics stage gives a damaged result
as long as no repair has edited the draft; what a repair makes again is as always. A row per object whose acceptance has
a failure that a rule of `assetkit.acceptance.repairs` answers: those failures, the repair that was kept, rounds,
processor seconds of the repairs (children included) and of the whole object. One JSON line per object in
OUT/repairs.jsonl; a run continues where it stopped.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from assetkit import pipeline
from assetkit.acceptance.repairs import RepairRule
from assetkit.acceptance.targeted_repair import Rerun, all_findings, repair_until_accepted
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Edits, Physics, Tools
from assetkit.stage_log import StageLog
from assetkit.stages.physics import AuthorPhysics
from assetkit.steps import Pipeline
from cli.engines import SIMULATOR
from geom.convex.hull import convex_hull, extreme_points
from geom.convex.placement import moved_shape
from geom.convex.support_function import diagonal, surface
from geom.pose import pose
from schemas.outcome import Outcome
from schemas.physics import CollisionShape
from sim.named_engine import load_engine

MOST_CORNERS = 60
ASIDE_SHARE = 0.2  # of the size, by which colliders are moved
SLIPPERY_SHARE = 0.1  # of the friction


def filled(physics: Physics) -> Physics:
    """One hull of everything in place of the colliders: openings are closed."""
    points = np.concatenate([surface(shape)[0] for shape in physics.shapes])
    points = points[extreme_points(points, min(MOST_CORNERS, len(points)))]
    hull = CollisionShape("hull", (), np.eye(4), *convex_hull(points))
    return replace(physics, shapes=(hull,), shape_surfaces=())


def aside(physics: Physics) -> Physics:
    """Colliders beside the visible surface."""
    shift = pose(None, (ASIDE_SHARE * diagonal(physics.shapes), 0.0, 0.0))
    return replace(physics, shapes=tuple(moved_shape(shape, shift) for shape in physics.shapes))


def halved(physics: Physics) -> Physics:
    """Every other collider is missing."""
    return replace(physics, shapes=physics.shapes[::2], shape_surfaces=physics.shape_surfaces[::2])


def slippery(physics: Physics) -> Physics:
    """A tenth of the friction, in the contact and on record; bounds stay."""
    contact = _slippery(physics.contact)
    contacts = tuple(e.model_copy(update={"value": _slippery(e.value)}) for e in physics.section.contacts)
    return replace(physics, contact=contact, section=physics.section.model_copy(update={"contacts": contacts}))


def _slippery(contact: Any) -> Any:
    lower = {n: SLIPPERY_SHARE * getattr(contact, n) for n in ("static_friction", "dynamic_friction")}
    return contact.model_copy(update=lower)


DAMAGES: Mapping[str, Callable[[Physics], Physics]] = {d.__name__: d for d in (filled, aside, halved, slippery)}


@dataclass(frozen=True)
class _Damaged(AuthorPhysics):
    """The physics stage, whose result is damaged as long as no repair has edited the draft."""

    damage: Callable[[Physics], Physics]

    def run(self, draft: Draft, tools: Tools) -> Outcome[Physics]:
        """As always, then damaged; mechanisms stay as they are."""
        outcome = super().run(draft, tools)
        if outcome.value is None or outcome.value.links or draft.edits != Edits():
            return outcome
        return replace(outcome, value=self.damage(outcome.value))


def main() -> None:
    """Run what is not in OUT yet, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--damage", choices=sorted(DAMAGES), action="append", default=[])
    arguments = parser.parse_args()
    log = arguments.out / "repairs.jsonl"
    log.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    done = {(row["damage"], row["source"]) for row in rows}
    with log.open("a") as file:
        for damage in arguments.damage or [""]:
            for source in arguments.sources:
                if (damage, str(source)) in done:
                    continue
                for row in measured(source, damage, arguments.out):
                    rows.append(row)
                    file.write(json.dumps(row) + "\n")
                    file.flush()
                    print(*row.values(), flush=True)
    print_table(rows)


def measured(source: Path, damage: str, out: Path) -> list[dict[str, Any]]:
    """A row per object of the source."""
    rows: list[dict[str, Any]] = []

    def timed(
        draft: Draft, log: StageLog, rules: Sequence[RepairRule], at_most: int, rerun: Rerun
    ) -> tuple[Draft, StageLog]:
        answered = frozenset[str]().union(*(rule.failures for rule in rules))
        codes = sorted({d.code for d in all_findings(log.diagnostics)} & answered)
        rounds: list[str] = []

        def counted(attempt: Draft, notes: StageLog, stage: str) -> Draft | None:
            rounds.append(stage)
            return rerun(attempt, notes, stage)

        before = _cpu_s()
        repaired, notes = repair_until_accepted(draft, log, rules, at_most, counted)
        entry = notes.entries.get("repair")
        kept = entry.repairs[0].name if entry is not None and entry.repairs else ""
        row = {"damage": damage, "source": str(source), "object": draft.asset_id, "rigid": draft[Physics].links == ()}
        rows.append({**row, "failed": codes, "kept": kept, "rounds": len(rounds), "repair_s": _cpu_s() - before})
        return repaired, notes

    stages = pipeline.STAGES if not damage else _with_physics(_Damaged(DAMAGES[damage]))
    with (
        load_engine(SIMULATOR)() as simulator,
        tempfile.TemporaryDirectory(prefix="repairs") as folder,
        mock.patch.object(pipeline, "repair_until_accepted", timed),
        mock.patch.object(pipeline, "STAGES", stages),
    ):
        for candidate in discover([source], out=out):
            started, first, work = _cpu_s(), len(rows), Path(folder) / candidate.asset_id
            work.mkdir()
            pipeline.process_source(
                candidate, options=Options(), simulator=simulator, out=Path(folder) / "out", work_dir=work, fresh=True
            )
            for row in rows[first:]:
                row["all_s"] = (_cpu_s() - started) / len(rows[first:])
    return rows


def _with_physics(stage: AuthorPhysics) -> Pipeline:
    steps = tuple(replace(s, stage=stage) if s.name == stage.name else s for s in pipeline.STAGES.steps)
    return Pipeline(steps)


def _cpu_s() -> float:
    """Processor seconds of this process and of its children that ended."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def print_table(rows: Sequence[dict[str, Any]]) -> None:
    """Per damage: objects, those with a failure that a rule answers, those repaired and by what, seconds."""
    for damage in dict.fromkeys(row["damage"] for row in rows):
        of_damage = [row for row in rows if row["damage"] == damage and (row["rigid"] or not damage)]
        failed = [row for row in of_damage if row["failed"]]
        kept = [row for row in failed if row["kept"]]
        names = {name: sum(row["kept"] == name for row in kept) for name in dict.fromkeys(row["kept"] for row in kept)}
        spent = [row["repair_s"] for row in failed]
        seconds = f"{np.median(spent):.1f} s, most {max(spent):.1f} s" if spent else "-"
        print(f"{damage or 'as they are':12} {len(of_damage)} objects, {len(failed)} fail first, {len(kept)} repaired "
              f"{names}; repairs take {seconds}")  # fmt: skip


if __name__ == "__main__":
    main()
