"""`mana gap plan`: the recording that it asks for settles what was in doubt, as tried with truth of an ODE solver."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from cli.main import app
from schemas.diagnostics import InvalidInput
from schemas.sim_gap.recording_plan import RecordingPlan
from schemas.sim_gap.report import GapReport

RUN = CliRunner()
DRAG, NOISE_RAD = 0.0006, 0.002
SPEC = f"""\
schema_version: 1
name: door
kind: mechanism
columns: {{t: t, q_door: angle}}
sensor_noise: {{q: {NOISE_RAD}}}
subject:
  joints: [{{name: door, inertia_kgm2: 0.01, gravity_load: {{mass_kg: 0.2, com_distance_m: 0.1}}}}]
"""


def record(folder: Path, name: str, far_rad: float, trials: int = 4, seed: int = 3) -> None:
    """Swings of a pendulum with quadratic drag that its model lacks, let go from about `far_rad`."""
    (folder / "trajectories").mkdir(parents=True, exist_ok=True)
    (folder / "measurement.yaml").write_text(SPEC)
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 1.5, 0.01)

    def change(_: float, state: np.ndarray) -> list[float]:
        return [state[1], (-0.2 * 9.81 * 0.1 * np.sin(state[0]) - DRAG * abs(state[1]) * state[1]) / 0.01]

    for k in range(trials):
        start = [far_rad * rng.uniform(0.95, 1.05) * (-1) ** k, 0.0]
        truth = solve_ivp(change, (0.0, t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-9).y[0]
        rows = np.c_[t, truth + rng.normal(scale=NOISE_RAD, size=len(t))]
        file = folder / "trajectories" / f"{name}{k}.csv"
        np.savetxt(file, rows, delimiter=",", header="t,angle", comments="")


def found(folder: Path, out: Path) -> GapReport:
    answer = RUN.invoke(app, ["gap", "find", str(folder), "--out", str(out), "--quick", "--json"])
    assert answer.exit_code == 0, answer.output
    return GapReport.model_validate_json((out / "report.json").read_bytes())


@pytest.fixture(scope="module")
def doubted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A recording of small swings, and its answer: drag that grows with speed, linearly or not."""
    folder, out = tmp_path_factory.mktemp("door"), tmp_path_factory.mktemp("gap")
    record(folder, "near", 0.4)
    verdict = found(folder, out).verdict
    assert verdict.status == "ambiguous"
    assert {"joint.quadratic_drag", "joint.viscous_friction"} <= set(verdict.ambiguous_groups[0].effects)
    return folder, out


def test_the_recording_that_is_asked_for_settles_the_doubt(doubted: tuple[Path, Path], tmp_path: Path):
    folder, out = doubted
    answer = RUN.invoke(app, ["gap", "plan", str(folder), str(out), "--json"])
    assert answer.exit_code == 0, answer.output
    plan = RecordingPlan.model_validate_json((out / "plan.json").read_bytes())
    assert json.loads(answer.output) == json.loads(plan.model_dump_json())
    assert all(d.left < d.needed for d in plan.open_questions)
    best, by_name = plan.recordings[0], {r.name: r for r in plan.recordings}
    assert best.name == "larger"
    assert best.separates
    # More of the same adds in proportion: three more copies leave at most four times what is left now.
    now = min(d.left for d in plan.open_questions)
    assert now < min(by_name["repeats"].left) <= 4.0 * now * (1.0 + 1e-3)
    assert not by_name["repeats"].separates

    both = tmp_path / "both"
    record(both, "near", 0.4)
    record(both, "far", 0.6, seed=4)
    verdict = found(both, tmp_path / "gap").verdict
    assert [e.name for e in verdict.effects if e.confidence > 0.9] == ["joint.quadratic_drag"]


def test_a_plan_needs_the_answer_to_the_same_recording(doubted: tuple[Path, Path], tmp_path: Path):
    folder, out = doubted
    missing = RUN.invoke(app, ["gap", "plan", str(folder), str(tmp_path)])
    assert isinstance(missing.exception, InvalidInput)
    assert missing.exception.diagnostic.code == "gap/missing-report"
    other = tmp_path / "other"
    record(other, "near", 0.5)
    strange = RUN.invoke(app, ["gap", "plan", str(other), str(out)])
    assert isinstance(strange.exception, InvalidInput)
    assert strange.exception.diagnostic.code == "gap/missing-report"
    assert "another measurement" in str(strange.exception)
