"""Renders `report.html` from a report and its pictures as one file: verdict first, then pictures, then evidence."""

from __future__ import annotations

import base64
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from schemas.gap import GapReport
from simgap.inference.verdict_text import share
from simgap.report.decision_table import decision_rows, outcome_counts
from simgap.report.pictures.ablation import ablation
from simgap.whole_trials.policy import POLICY

REPORT, PAGE, PICTURES = "report.json", "report.html", "pictures"
# Order on the page; those that are absent are left out.
_TITLES = {
    "overlay.png": "measured and simulated motion",
    "unexplained.png": "what the model does not account for",
    "ladder.png": "where the error goes",
}


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
    pages.globals["share"] = share
    rows = decision_rows(report.decisions)
    return pages.get_template("gap.html").render(
        report=report,
        pictures=pictures,
        name=report.measurement_name or f"measurement {report.measurement[:12]}",
        decisions=rows,
        counts=outcome_counts(rows),
        contrast=POLICY.contrast,
    )
