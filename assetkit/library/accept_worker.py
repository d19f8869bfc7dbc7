"""Entry of the cell of `mana assets accept`: runs suites on one package and writes what they found."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from assetkit.acceptance.body_checks import body_checks
from assetkit.acceptance.joints.judge_joints import judge_joints
from assetkit.acceptance.judge_body import accept
from assetkit.acceptance.on_record import declared_on_record, judge_record
from assetkit.acceptance.suites.run import SuiteResult, run_suite, suites_for
from assetkit.acceptance.suites.subject import is_recorded, record_of, subject_on_disk
from assetkit.acceptance.suites.suite import Subject, at_most
from assetkit.acceptance.suites.table import SUITES
from assetkit.library.acceptance_request import GATE, OBJECT, ON_RECORD, AcceptanceReport, AcceptanceRequest
from gate.static_gate import gate
from jobs.cache import write_atomically
from schemas.acceptance import SuiteSection
from schemas.diagnostics import Diagnostic, InvalidInput, Severity
from sim.named_engine import load_engine
from sim.port import Simulator

_SENSELESS = frozenset({"asset/package-invalid", "asset/unstable-settling", "asset/joint-unstable"})


def accept_package(request: AcceptanceRequest) -> AcceptanceReport:
    """What the suites of the request find on its package; the finding alone where the file holds no complete body."""
    main_file = Path(request.main_file)
    simulator: Simulator = load_engine(request.engine)()
    try:
        subject = subject_on_disk(main_file, simulator, request.roles)
    except InvalidInput as invalid:
        return AcceptanceReport(findings=(invalid.diagnostic,))
    chosen = [s for s in SUITES if s.name in request.suites] if request.suites else suites_for(subject, SUITES)
    sections: list[SuiteSection] = []
    findings: list[Diagnostic] = list(subject.findings)
    for name, judge in ((GATE, _static), (OBJECT, _whole_object), (ON_RECORD, _record)):
        if not request.suites or name in request.suites:
            section, found = judge(subject, simulator)
            sections.append(section)
            findings += found
    # What makes no sense, or does not come to rest, cannot be handled.
    if senseless := sorted({finding.code for finding in findings} & _SENSELESS):
        unrun = [SuiteSection(name=s.name, outcome="not_run", reason=f"'{senseless[0]}'") for s in chosen]
        return AcceptanceReport(roles=subject.roles, suites=(*sections, *unrun), findings=tuple(findings))
    results = [run_suite(suite, subject, simulator, thorough=request.thorough) for suite in chosen]
    sections += [result.section for result in results]
    findings += [finding for result in results for finding in result.findings]
    video = _filmed(subject, results, Path(request.video)) if request.video else ""
    return AcceptanceReport(roles=subject.roles, suites=tuple(sections), findings=tuple(findings), video=video)


def _filmed(subject: Subject, results: Sequence[SuiteResult], out: Path) -> str:
    """The GIF of the motions of the suites, the path of it as text; "" where nothing moved."""
    from assetkit.library.acceptance_video import write_video
    from assetkit.library.drawn_package import drawn_package

    runs = [result.nominal for result in results if result.nominal is not None]
    grasp = next((run.trace for run in runs if run.trace is not None), None)
    handled = [trace for run in runs for trace in run.handled]
    written = write_video(drawn_package(subject.main_file, subject.content), grasp, handled, out)
    return "" if written is None else str(written)


def _static(subject: Subject, simulator: Simulator) -> tuple[SuiteSection, tuple[Diagnostic, ...]]:
    """The errors of the static gate; nothing is simulated."""
    errors = tuple(d for d in gate(subject.main_file) if d.severity is Severity.ERROR)
    check = at_most("errors", len(errors), 0, "")
    return SuiteSection(name=GATE, outcome="failed" if errors else "passed", checks=(check,)), errors


def _whole_object(subject: Subject, simulator: Simulator) -> tuple[SuiteSection, tuple[Diagnostic, ...]]:
    """Frame, colliders, mass, settling and stable poses, and the exercise of joints."""
    content, record = subject.content, record_of(subject.main_file)
    result = accept(
        subject.main_file,
        simulator,
        body=content.body,
        visual=(content.visual_points, content.visual_triangles),
        extent_m=None if record is None else record.geometry.extent_m.value,
        links=content.links,
    )
    if content.mechanism is not None and result.is_simulated:
        joints = judge_joints(
            subject.main_file,
            content,
            simulator,
            declared=content.mechanism
            if record is None
            else declared_on_record(content.mechanism, record.physics.joints),
            contacts={use.joint: use.contact.value for use in subject.joint_uses if use.contact is not None},
            anchors=subject.anchors,
            has_twins=is_recorded(subject.main_file),
        )
        result = result.with_joints(joints)
    outcome = "passed" if result.passed else "failed"
    return SuiteSection(name=OBJECT, outcome=outcome, checks=result.section.checks), result.diagnostics


def _record(subject: Subject, simulator: Simulator) -> tuple[SuiteSection, tuple[Diagnostic, ...]]:
    """What is on record, tried again; not without a record, nor with bodies that cannot be simulated."""
    if record_of(subject.main_file) is None:
        return SuiteSection(name=ON_RECORD, outcome="not_run", reason="it has no record of Mana"), ()
    if not all(check.passed for body in subject.content.bodies for check in body_checks(body)):
        return SuiteSection(name=ON_RECORD, outcome="not_run", reason="its bodies cannot be simulated"), ()
    run = judge_record(subject, simulator)
    outcome = "passed" if run.passes else "failed"
    return SuiteSection(name=ON_RECORD, outcome=outcome, checks=run.checks), run.findings


def main(request: str, reply: str) -> None:
    """Run the request in the JSON file `request`, write the report to `reply`."""
    report = accept_package(AcceptanceRequest.model_validate_json(Path(request).read_bytes()))
    write_atomically(Path(reply), report.model_dump_json().encode())


if __name__ == "__main__":
    main(*sys.argv[1:3])
