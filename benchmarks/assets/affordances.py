"""Compares affordances of objects with what a person sees, and counts the proposed grasps that hold in simulation.

    python -m benchmarks.assets.affordances ASSETS_DIR [--only TEXT] [--tried N] [--no-names]

`affordances_truth.csv` says for objects of the development assets and of `pybullet_data`, standing with `up_axis` up,
whether a person sees a way to pick them up with a gripper that opens 80 mm, a handle, a rim to pour over, a spout, a
hole or loop to hang them up by, a lid, a knob or button. Affordances listed as `may` count neither as missed nor as
wrong. A grasp counts unless its trial refutes it. With `--no-names` files, nodes and materials have no names, so that
parts have no labels.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from assetkit.acceptance.stable_poses import find_stable_poses
from assetkit.affordances.anchor_trials import verify_anchors
from assetkit.affordances.find import find_affordances
from assetkit.affordances.grasp_trials import TRIED
from assetkit.options import Options
from assetkit.stage import Draft, Tools
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.semantics import DescribeObject
from benchmarks.assets.truth_files import located, object_of
from schemas.affordances import AffordanceEvidence, Grasp
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator

TABLE = Path(__file__).with_name("affordances_truth.csv")
COLUMNS = {
    "grasp": {"grasp"},
    "handle": {"handle"},
    "rim": {"rim"},
    "spout": {"spout"},
    "hang": {"hang_hole"},
    "lid": {"lid"},
    "knob_button": {"knob", "button"},
}


class Row(NamedTuple):
    """One object: what was said of each column of the table, its grasps, why it has none, seconds."""

    path: str
    truth: dict[str, str]
    found: set[str]
    trials: list[str]
    why: str
    seconds: float


def draft_of(file: Path, root: Path, up_axis: str, simulator: BulletSimulator, work_dir: Path) -> Draft:
    """The largest object of a file, through all stages up to physics."""
    options = Options.model_validate({"up_axis": up_axis})
    draft = Draft("thing", file.name, object_of(file, options, root))
    tools = Tools(simulator, work_dir, options)
    for stage in (Canonicalize(), NormalizeAppearance(), DescribeObject(), ProposeParts(), AuthorPhysics()):
        value = stage.run(draft, tools).value
        assert value is not None, f"{file} is not refused"
        draft = replace(draft, **{stage.name: value})
    return draft


def nameless(draft: Draft) -> Draft:
    """The same object with parts that nobody can name."""
    assert draft.interaction is not None, "interaction has run"
    return replace(draft, interaction=replace(draft.interaction, parts=()))


def affordances_of(
    draft: Draft, simulator: BulletSimulator, tried: int
) -> tuple[tuple[AffordanceEvidence, ...], str, float]:
    """What a draft offers, why it has no grasp, and the CPU seconds it took."""
    assert draft.physics is not None, "physics has run"
    assert draft.interaction is not None, "interaction has run"
    body = RigidBody("thing", draft.physics.shapes, draft.physics.mass, draft.physics.contact)
    poses = find_stable_poses(body, simulator).poses
    anchors = verify_anchors(draft.interaction.anchors, body.shapes, simulator).anchors
    started = time.process_time()
    offered = find_affordances(draft, body, poses, anchors, simulator, tried=tried)
    seconds = time.process_time() - started
    why = next((d.headline for d in offered.diagnostics if d.code == "asset/no-grasp"), "")
    return offered.affordances, why, seconds


def rows(assets: Path, *, only: str = "", tried: int = TRIED, names: bool = True) -> Iterator[Row]:
    """The rows of the table whose path holds `only`."""
    with TABLE.open(encoding="utf-8") as file, BulletSimulator() as simulator:
        for truth in csv.DictReader(file):
            if only not in truth["path"]:
                continue
            file_at, root = located(assets, truth["path"])
            with tempfile.TemporaryDirectory() as folder:
                draft = draft_of(file_at, root, truth["up_axis"], simulator, Path(folder))
            draft = draft if names else nameless(draft)
            offered, why, seconds = affordances_of(draft, simulator, tried)
            grasps = [e.value for e in offered if isinstance(e.value, Grasp)]
            standing = {e.value.kind for e in offered if e.confidence > 0.0}
            said = {column for column, kinds in COLUMNS.items() if kinds & standing}
            trials = [g.trial for g in grasps]
            yield Row(truth["path"], truth, said, trials, why, seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--tried", type=int, default=TRIED, help="grasps tried of each object")
    parser.add_argument("--no-names", action="store_true")
    arguments = parser.parse_args()
    table = []
    for row in rows(arguments.assets, only=arguments.only, tried=arguments.tried, names=not arguments.no_names):
        table.append(row)
        notes = [f"missed {c}" for c in COLUMNS if row.truth[c] == "yes" and c not in row.found]
        notes += [f"wrong {c}" for c in COLUMNS if row.truth[c] == "no" and c in row.found]
        held, refuted = row.trials.count("held"), row.trials.count("not_held")
        words = [" ".join(sorted(row.found)), f"{len(row.trials)} grasps, {held} held, {refuted} not", row.why]
        print(f"{row.path:80} {row.seconds:5.2f} s  {'; '.join(filter(None, [*words, *notes]))}", flush=True)
    print(f"{len(table)} objects")
    for column in COLUMNS:
        asked = [r for r in table if r.truth[column] == "yes"]
        judged = [r for r in table if column in r.found and r.truth[column] != "may"]
        right = sum(column in r.found for r in asked)
        print(f"{column:12} found {right} of {len(asked)}, wrong {len(judged) - right} of {len(judged)}")
    trials = [t for r in table for t in r.trials]
    tried = len(trials) - trials.count("untried")
    print(
        f"grasps {len(trials)}, tried {tried}, held {trials.count('held')} ({trials.count('held') / max(tried, 1):.0%})"
    )
    able = [r for r in table if r.trials]
    print(f"objects with grasps {len(able)}, with one that held {sum('held' in r.trials for r in able)}")
    seconds = sorted(r.seconds for r in table)
    print(f"median {seconds[len(seconds) // 2]:.2f} s, slowest {seconds[-1]:.2f} s of CPU an object")


if __name__ == "__main__":
    main()
