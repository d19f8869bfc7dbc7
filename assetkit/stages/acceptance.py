"""Stage 7, acceptance: writes the package, reads it back from disk, judges it by validators and simulator."""

from __future__ import annotations

from dataclasses import replace

from assetkit.acceptance.judge_package import judge_bytes, package_files, require_files, simulate_package
from assetkit.affordances.anchor_trials import verify_anchors
from assetkit.affordances.find import find_affordances
from assetkit.affordances.grasp_pictures import drawn_grasps
from assetkit.affordances.grasp_trials import grasp_lines
from assetkit.package import release
from assetkit.package.preview_images import render_previews
from assetkit.stage import (
    Acceptance,
    Appearance,
    Canonical,
    Draft,
    Interaction,
    Physics,
    Previews,
    Semantics,
    Stage,
    Tools,
)
from schemas.outcome import Outcome
from usdio.reread.body import reread_body
from usdio.write.source_names import rename_findings, source_names


class AcceptPackage(Stage):
    """Judges the bytes that are shipped, never the values in memory."""

    name = "acceptance"
    version = 6
    result = Acceptance
    reads = (Canonical, Appearance, Semantics, Interaction, Physics, Previews)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Acceptance]:
        """Validator verdicts, gate findings, simulator figures of the package on disk; anchors and grasps tried on it.

        What the simulator finds is written into the package before validators and gate judge its bytes.
        """
        main_file = release.author(draft, tools.work_dir)
        extent_m = draft[Canonical].section.extent_m.value
        collider_misses_bounds = draft[Physics].section.collider_misses_bounds
        names = rename_findings(source_names(draft.model))
        simulated = simulate_package(main_file, tools.simulator, extent_m)
        body = reread_body(main_file)
        proposed = draft[Interaction].anchors
        anchors = verify_anchors(proposed, body.shapes, tools.simulator)
        poses = [pose.value for pose in simulated.section.stable_poses]
        offered = find_affordances(draft, body, poses, anchors.anchors, tools.simulator, sound=simulated.passed)
        drawn = drawn_grasps(offered.affordances)
        images = render_previews(draft.model, (), tools.work_dir, grasps=drawn) if drawn else {}
        acceptance = Acceptance(simulated.section, anchors.anchors, offered.affordances, images)
        if grasp_lines(offered.affordances):
            main_file = release.author(replace(draft, acceptance=acceptance), tools.work_dir)
        written = package_files(main_file)
        judged = judge_bytes(main_file, simulated, collider_misses_bounds)
        require_files(written)
        diagnostics = (*names, *judged.diagnostics, *anchors.diagnostics, *offered.diagnostics)
        return Outcome(replace(acceptance, section=judged.section), diagnostics, review=judged.review)
