"""The work of `mana gap plan`: from a measurement and its answer to the plan, as a file beside the report."""

from __future__ import annotations

from pathlib import Path

from cli.engines import REPLAY_ENGINE
from jobs.cache import write_atomically
from schemas.diagnostics import InvalidInput, finding
from schemas.sim_gap.recording_plan import RecordingPlan
from schemas.sim_gap.report import GapReport
from simgap.case import case_of
from simgap.recording.read import Measurement
from simgap.report.html import REPORT
from simgap.whole_trials.plan_recordings import plan_recordings


def plan(measurement: Measurement, answer: Path) -> RecordingPlan:
    """The plan that is also written as `plan.json` into the folder of the answer.

    Raises InvalidInput where that folder holds no report, or that of another measurement.
    """
    if not (answer / REPORT).is_file():
        raise InvalidInput(finding("gap/missing-report", f"{answer.name} holds no {REPORT}"))
    report = GapReport.model_validate_json((answer / REPORT).read_bytes())
    if report.measurement != measurement.content_hash:
        text = f"the report in {answer.name} is that of another measurement, or the folder has changed since"
        raise InvalidInput(finding("gap/missing-report", text))
    case = case_of(measurement, REPLAY_ENGINE)
    recording_plan = plan_recordings(case.problem, case.trials.train, report.verdict, measurement.content_hash)
    write_atomically(answer / "plan.json", recording_plan.model_dump_json(indent=1).encode())
    return recording_plan
