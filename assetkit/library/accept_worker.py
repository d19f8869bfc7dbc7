"""Entry of the cell of `mana assets accept`: runs suites on one package and writes what they found."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from assetkit.acceptance.joints.judge_joints import judge_joints
from assetkit.acceptance.judge_body import accept
from assetkit.acceptance.suites.run import SuiteResult, run_suite, suites_for
from assetkit.acceptance.suites.subject import is_recorded, record_of, subject_on_disk
from assetkit.acceptance.suites.suite import Subject, at_most
from assetkit.acceptance.suites.table import SUITES
from assetkit.library.acceptance_request import GATE, OBJECT, AcceptanceReport, AcceptanceRequest
from gate.static_gate import gate
from jobs.cache import write_atomically
from schemas.acceptance import SuiteSection
from schemas.diagnostics import Diagnostic, InvalidInput, Severity
from sim.named_engine import load_engine
from sim.port import Simulator


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
    for name, judge in ((GATE, _static), (OBJECT, _whole_object)):
        if not request.suites or name in request.suites:
            section, found = judge(subject, simulator)
            sections.append(section)
            findings += found
    # What makes no sense at rest cannot be handled.
    broken = [section.name for section in sections if section.name == OBJECT and section.outcome == "failed"]
    if broken:
        unrun = [SuiteSection(name=s.name, outcome="not_run", reason=f"'{OBJECT}' failed") for s in chosen]
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
            declared=content.mechanism,
            contacts={use.joint: use.contact.value for use in subject.joint_uses if use.contact is not None},
            anchors=subject.anchors,
            has_twins=is_recorded(subject.main_file),
        )
        result = result.with_joints(joints)
    outcome = "passed" if result.passed else "failed"
    return SuiteSection(name=OBJECT, outcome=outcome, checks=result.section.checks), result.diagnostics


def main(request: str, reply: str) -> None:
    """Run the request in the JSON file `request`, write the report to `reply`."""
    report = accept_package(AcceptanceRequest.model_validate_json(Path(request).read_bytes()))
    write_atomically(Path(reply), report.model_dump_json().encode())


if __name__ == "__main__":
    main(*sys.argv[1:3])
