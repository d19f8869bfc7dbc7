"""Renders `report.html` from a report and its pictures as one file: verdict first, then pictures, then evidence."""

from __future__ import annotations

import base64
import math
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from schemas.sim_gap.report import EngineDifference, GapReport
from simgap.inference.verdict_text import share
from simgap.report.decision_table import decision_rows, outcome_counts
from simgap.report.pictures.ablation import ablation
from simgap.whole_trials.policy import POLICY

REPORT, PAGE, PICTURES = "report.json", "report.html", "pictures"
# Order on the page; those that are absent are left out.
_TITLES = {
    "overlay.png": "measured and simulated motion",
    "unexplained.png": "what the model does not account for",
    "left_over.png": "what the best model of the library leaves: by position, speed and time",
    "ladder.png": "where the error goes",
    "engines.png": "whose error: the declared model here and in the user's engine",
}


def engine_share(difference: EngineDifference) -> str:
    """What the two roll-outs differ by, over the rms error against the recording, as words."""
    if not math.isfinite(difference.between_engines):
        return "it diverged"
    return f"{100.0 * difference.between_engines / max(difference.ours_to_recording, 1e-300):.2g} % of the gap"


def render_page(report: GapReport, folder: Path) -> str:
    """The page as text, with the pictures of `folder`; that of the ladder is drawn from the report."""
    pictures = []
    for name, title in _TITLES.items():
        file = folder / PICTURES / name
        if name == "ladder.png" and report.ladder:
            data = ablation(report.ladder)
        elif file.is_file():
            data = file.read_bytes()
        else:
            continue
        pictures.append((title, base64.b64encode(data).decode("ascii")))
    loader = PackageLoader("simgap.report", "templates")
    pages = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    pages.globals |= {"share": share, "engine_share": engine_share}
    rows = decision_rows(report.decisions)
    return pages.get_template("gap.html").render(
        report=report,
        pictures=pictures,
        name=report.measurement_name or f"measurement {report.measurement[:12]}",
        decisions=rows,
        counts=outcome_counts(rows),
        contrast=POLICY.contrast,
        twin=POLICY.twin,
    )
