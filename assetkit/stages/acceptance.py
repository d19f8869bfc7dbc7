"""Stage 7, acceptance: writes the package, reads it back from disk, judges it by validators and simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from assetkit.acceptance.joints.checks import JudgedJoint
from assetkit.acceptance.joints.judge_joints import judge_joints
from assetkit.acceptance.judge_body import AcceptanceResult
from assetkit.acceptance.judge_package import judge_bytes, require_files, simulate_package
from assetkit.acceptance.suites.roles import judge_roles
from assetkit.acceptance.suites.run import SuiteResult, run_suite, suites_for
from assetkit.acceptance.suites.subject import subject_of
from assetkit.acceptance.suites.table import SUITES
from assetkit.affordances.anchor_trials import VerifiedAnchors, verify_anchors
from assetkit.affordances.find import find_affordances
from assetkit.affordances.grasp_pictures import drawn_grasps
from assetkit.affordances.grasp_trials import TRIED, grasp_lines
from assetkit.articulation.link_anchor_trials import placed, verify_link_anchors
from assetkit.articulation.roles import roles_with_joints
from assetkit.package import release
from assetkit.package.package import reread
from assetkit.package.preview_images import render_previews
from assetkit.stage import (
    Acceptance,
    Appearance,
    Canonical,
    Draft,
    Interaction,
    Physics,
    Previews,
    Recovery,
    Semantics,
    Stage,
    Tools,
)
from geom.pose import pose
from schemas.anchors import Anchor
from schemas.evidence import Evidence
from schemas.outcome import Outcome
from sim.port import Simulator
from usdio.reread.body import RereadPackage
from usdio.write.source_names import rename_findings, source_names


class AcceptPackage(Stage):
    """Judges the bytes that are shipped, never the values in memory."""

    name = "acceptance"
    version = 13
    result = Acceptance
    reads = (Canonical, Appearance, Semantics, Interaction, Recovery, Physics, Previews)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Acceptance]:
        """Validator verdicts, gate findings, simulator figures of the package on disk; anchors and grasps tried on it.

        What the simulator finds is written into the package before validators and gate judge its bytes.
        """
        package = release.author(draft, tools)
        content = reread(package.main_file)
        extent_m = draft[Canonical].section.extent_m.value
        collider_misses_bounds = draft[Physics].section.collider_misses_bounds
        names = rename_findings(source_names(draft.model))
        simulated = simulate_package(package.main_file, content, tools.simulator, extent_m)
        anchors = _verified_anchors(draft, content, tools.simulator)
        poses = [pose.value for pose in simulated.section.stable_poses]
        offered = find_affordances(
            draft,
            content.body,
            poses,
            anchors.anchors,
            tools.simulator,
            sound=simulated.passed,
            tried=draft.edits.tried_grasps or TRIED,
        )
        drawn = drawn_grasps(offered.affordances)
        images = render_previews(draft.model, (), tools.work_dir, grasps=drawn) if drawn else {}
        acceptance = Acceptance(simulated.section, anchors.anchors, offered.affordances, images)
        package = release.with_grasps(package, draft, grasp_lines(offered.affordances), tools)
        joints = _judged_joints(package.main_file, draft, simulated, anchors.anchors, tools)
        simulated = simulated.with_joints(joints)
        roles = roles_with_joints(draft[Semantics].section.roles, draft[Interaction].joint_uses)
        results = _suite_results(package.main_file, draft, simulated, acceptance, roles, tools)
        role_verdict = judge_roles(roles, results)
        judged = judge_bytes(package.main_file, simulated, collider_misses_bounds)
        require_files(package)
        diagnostics = (*names, *judged.diagnostics, *anchors.diagnostics, *offered.diagnostics, *role_verdict.findings)
        section = judged.section.model_copy(update={"suites": tuple(result.section for result in results)})
        return Outcome(
            replace(acceptance, section=section, withdrawn_roles=role_verdict.withdrawn),
            diagnostics,
            review=judged.review or joints.review or role_verdict.review,
        )


def _suite_results(
    main_file: Path,
    draft: Draft,
    simulated: AcceptanceResult,
    acceptance: Acceptance,
    roles: Sequence[Evidence[str]],
    tools: Tools,
) -> tuple[SuiteResult, ...]:
    """The suites of the roles, on the package as it is on disk; none for an object that fails as a whole."""
    if not simulated.passed:
        return ()
    subject = subject_of(
        main_file,
        reread(main_file),
        roles=roles,
        poses=[pose.value for pose in simulated.section.stable_poses],
        affordances=acceptance.affordances,
        anchors=[anchor.value for anchor in acceptance.anchors],
        joint_uses=draft[Interaction].joint_uses,
        physics=draft[Physics].section,
    )
    subject = replace(subject, most_grasps=max(subject.most_grasps, draft.edits.tried_grasps))
    return tuple(run_suite(suite, subject, tools.simulator) for suite in suites_for(subject, SUITES))


def _judged_joints(
    main_file: Path, draft: Draft, simulated: AcceptanceResult, anchors: Sequence[Evidence[Anchor]], tools: Tools
) -> JudgedJoint:
    """The verdict on the joints of an articulated object whose bodies make sense."""
    declared = draft[Canonical].mechanism
    if declared is None or not simulated.is_simulated:
        return JudgedJoint((), ())
    holding = [anchor.value for anchor in anchors]
    contacts = {u.joint: u.contact.value for u in draft[Interaction].joint_uses if u.contact is not None}
    return judge_joints(
        main_file,
        reread(main_file),
        tools.simulator,
        declared=declared,
        contacts=contacts,
        anchors=holding,
    )


def _verified_anchors(draft: Draft, content: RereadPackage, simulator: Simulator) -> VerifiedAnchors:
    """The proposed anchors, tried on the collision shapes of the package; of an articulated object link by link."""
    interaction, mechanism = draft[Interaction], draft[Canonical].mechanism
    if mechanism is None or content.mechanism is None:
        return verify_anchors(interaction.anchors, content.body.shapes, simulator)
    by_link = {
        link.name: [placed(shape, pose(None, link.origin)) for shape in body.shapes]
        for link, body in zip(content.mechanism.links, content.links, strict=True)
    }
    return verify_link_anchors(interaction.anchors, by_link, mechanism, interaction.joint_uses, simulator)
