"""Every `measurement.yaml` of the how-to page is read without a warning, and its trials are simulated."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.engines import REPLAY_ENGINE
from cli.main import app
from schemas.diagnostics import InvalidInput
from schemas.measurement import KINDS
from simgap.case import case_of
from tests.support.bad_inputs.gap import Columns, events, flight, folder_of, pushed, swing
from tests.support.measurements import codes, sound
from tests.support.worked_pages import FENCE

PAGE = Path(__file__).parents[2] / "docs/how-to/simgap.md"
BLOCKS = [text for language, text in FENCE.findall(PAGE.read_text()) if language == "yaml"]
SPECS = {kind: text for text in BLOCKS for kind in KINDS if f"kind: {kind}\n" in text}
ARM = """\
<robot name="arm"><link name="base"/>
<link name="tip"><inertial>
<mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="5" velocity="5"/></joint></robot>
"""


def driven(seed: int) -> Columns:
    columns = swing(seed)
    qdd = np.gradient(columns["rate"], columns["t"])
    torque_Nm = 0.01 * qdd + 0.2 * 9.81 * 0.1 * np.sin(columns["angle"])
    return columns | {"current": torque_Nm / 0.05, "battery": np.full(len(qdd), 12.0), "target": columns["angle"]}


def tossed(seed: int) -> Columns:
    columns = flight(seed)
    return columns | {"pz": columns["pz"] + 50.0}  # High above the support.


def recorded(folder: Path, kind: str) -> Path:
    """The page's file beside trials with the columns that it names."""
    tables: dict[str, Columns | str] = {f"t{k}": tossed(k) if kind == "free_body" else driven(k) for k in range(4)}
    if kind == "impact":
        tables = {"events": events(0)}
    if kind == "push":
        tables = {f"p{k}.{part}": table for k in range(4) for part, table in pushed(k).items()}
    folder_of(folder, SPECS[kind], tables)
    if kind == "tracking":
        (folder / "arm.urdf").write_text(ARM)
    return folder


def test_the_page_has_one_file_per_kind():
    assert len(BLOCKS) == len(KINDS)
    assert set(SPECS) == set(KINDS)


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "tracking"])
def test_its_trials_are_simulated(tmp_path: Path, kind: str):
    folder = recorded(tmp_path / kind, kind)
    assert codes(folder) == set()
    done = CliRunner().invoke(app, ["gap", "simulate", str(folder), "--out", str(tmp_path / "out"), "--json"])
    assert done.exit_code == 0, done.output
    rows = json.loads((tmp_path / "out/errors.json").read_text())["errors"]
    assert rows
    assert all(np.isfinite(row["rmse"]) for row in rows)


def test_the_file_for_tracking_is_read_and_not_searched(tmp_path: Path):
    measurement = sound(recorded(tmp_path, "tracking"))
    assert measurement.joints == ("hinge",)
    with pytest.raises(InvalidInput, match="no search explains them yet"):
        case_of(measurement, REPLAY_ENGINE)
