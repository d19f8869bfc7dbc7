"""Stage 7, acceptance: write the package, read it back from disk, let validators and the simulator judge that."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass, replace
from pathlib import Path

from assetkit.acceptance.judge_body import AcceptanceResult, accept
from assetkit.affordances.anchor_trials import verify_anchors
from assetkit.affordances.find import find_affordances
from assetkit.affordances.grasp_pictures import drawn_grasps
from assetkit.affordances.grasp_trials import grasp_lines
from assetkit.package import release
from assetkit.stage import Acceptance, Draft, Stage, Tools, need
from assetkit.stages.previews import render
from gate.external_validators import Remark, outside_verdicts
from gate.static_gate import gate
from schemas.asset import AcceptanceSection, Check, Vec3
from schemas.diagnostics import Diagnostic, Location, Severity, finding
from schemas.outcome import Outcome
from sim.port import Simulator
from usdio.reread.body import reread_body, reread_visual
from usdio.source_names import renamed, source_names

# Either the unit of the source or its category is wrong, or the thing is a toy: a person must say which.
UNDECIDED = frozenset({"asset/gate-category-size"})
# What a collider that misses its bounds, and says so, may be found guilty of.
OF_STAND_INS = frozenset({"asset/gate-collider-astray", "asset/gate-collider-displaced"})


class AcceptPackage(Stage):
    """Nothing is released on the strength of what is in memory: the bytes judged are the bytes shipped."""

    name = "acceptance"
    version = 6
    result = Acceptance

    def run(self, draft: Draft, tools: Tools) -> Outcome[Acceptance]:
        """Validator verdicts, gate findings, simulator figures of the package on disk; anchors and grasps tried on it.

        What the simulator finds is written into the package before validators and gate judge its bytes.
        """
        main_file = release.author(draft, tools.work_dir)
        extent_m = need(draft.canonicalize, "canonicalize").section.extent_m.value
        stands_in = need(draft.physics, "physics").section.stands_in
        names = renamed(source_names(draft.model))
        simulated = simulate_package(main_file, tools.simulator, extent_m)
        body = reread_body(main_file)
        proposed = need(draft.interaction, "interaction").anchors
        anchors = verify_anchors(proposed, body.shapes, tools.simulator)
        poses = [pose.value for pose in simulated.section.stable_poses]
        offered = find_affordances(draft, body, poses, anchors.anchors, tools.simulator, sound=simulated.passed)
        drawn = drawn_grasps(offered.affordances)
        images = render(draft.model, (), tools.work_dir, grasps=drawn) if drawn else {}
        found = Acceptance(simulated.section, anchors.anchors, offered.affordances, images)
        if grasp_lines(offered.affordances):
            main_file = release.author(replace(draft, acceptance=found), tools.work_dir)
        written = package_files(main_file)
        judged = judge_bytes(main_file, simulated, stands_in)
        require_files(written)
        diagnostics = (*names, *judged.diagnostics, *anchors.diagnostics, *offered.diagnostics)
        return Outcome(replace(found, section=judged.section), diagnostics, review=judged.review)


def package_files(main_file: Path) -> tuple[Path, ...]:
    """The files of the package with this main file, as they are on disk."""
    return tuple(sorted(p for p in main_file.parent.parent.rglob("*") if p.is_file()))


def require_files(paths: tuple[Path, ...]) -> None:
    """Raises FileNotFoundError for the first that has vanished: a verdict on what is left would be about nothing."""
    for path in paths:
        if not path.is_file():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))


@dataclass(frozen=True)
class Judged:
    """What is written in the record, what is to be told, and whether a person should look."""

    section: AcceptanceSection
    diagnostics: tuple[Diagnostic, ...]
    review: bool


def judge_package(main_file: Path, simulator: Simulator, extent_m: Vec3, stands_in: bool = False) -> Judged:
    """Outside validators, gate and simulator on the package with this main file, as it lies on disk.

    Of a collider that only `stands_in` it is known that it misses its bounds: a person looks at it anyway.
    """
    return judge_bytes(main_file, simulate_package(main_file, simulator, extent_m), stands_in)


def simulate_package(main_file: Path, simulator: Simulator, extent_m: Vec3) -> AcceptanceResult:
    """What the simulator says about the body of a package, as re-read from disk."""
    return accept(main_file, simulator, body=reread_body(main_file), visual=reread_visual(main_file), extent_m=extent_m)


def judge_bytes(main_file: Path, simulated: AcceptanceResult, stands_in: bool) -> Judged:
    """Outside validators and gate on the files of a package, beside what the simulator said of its body."""
    verdicts = outside_verdicts(main_file)
    judged_by_gate = gate(main_file)
    review = any(d.code in UNDECIDED and d.severity is Severity.ERROR for d in judged_by_gate)
    known = UNDECIDED | (OF_STAND_INS if stands_in else frozenset())
    gate_findings = tuple(_for_a_person(d, known) for d in judged_by_gate)
    errors = [d for d in gate_findings if d.severity is Severity.ERROR]
    validators = tuple(_check(v.judge, len(v.findings)) for v in verdicts)
    validators += (_check("mana gate", len(errors)),)
    section = simulated.section.model_copy(update={"validators": validators})
    refused = tuple(_refused(v.judge, v.findings) for v in verdicts if not v.passed)
    return Judged(section, (*refused, *gate_findings, *simulated.diagnostics), review)


def _for_a_person(diagnostic: Diagnostic, known: frozenset[str]) -> Diagnostic:
    """A finding about what only a person can decide no longer refuses the package."""
    undecided = diagnostic.code in known
    return diagnostic.model_copy(update={"severity": Severity.WARNING}) if undecided else diagnostic


def _check(name: str, errors: int) -> Check:
    return Check(name=name, value=errors, bound=0, unit="errors", passed=errors == 0)


def _refused(name: str, found: tuple[Remark, ...]) -> Diagnostic:
    return finding(
        "asset/package-invalid",
        f"{name} refuses the package: {found[0]}",
        where=Location(prim=found[0].prim or None),
        value=len(found),
        bound=0,
        unit="errors",
    )
