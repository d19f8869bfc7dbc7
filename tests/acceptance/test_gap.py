"""`mana gap` from a folder to an answer, with truth made by an ODE solver that shares no code with our simulation."""

from __future__ import annotations

import json
import pickle
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from cli.demo.gap import FRICTION_NM, gap_demo
from cli.demo.page import _pictures
from cli.engines import REPLAY_ENGINE
from cli.main import app
from schemas.diagnostics import InvalidInput
from schemas.sim_gap.report import GapReport
from simgap.recording.read import read
from simgap.report.decision_table import decision_rows
from simgap.result_store import ResultStore
from simgap.run import answer_key, search
from simgap.whole_trials.policy import POLICY
from tests.support.bad_inputs.gap import SAMPLES
from tests.support.gap.decisions import contradictions

RUN = CliRunner()
DAMPING = 0.004
SPEC = """\
schema_version: 1
name: door
kind: mechanism
columns: {t: t, q_door: angle}
subject:
  joints: [{name: door, inertia_kgm2: 0.01, gravity_load: {mass_kg: 0.2, com_distance_m: 0.1}}]
"""


DOOR_URDF = """\
<robot name="d"><link name="a"/><link name="b"/>
<joint name="door" type="revolute"><parent link="a"/><child link="b"/><limit effort="1" velocity="1"/></joint></robot>
"""


def swings(folder: Path, trials: int = 8) -> Path:
    """A pendulum with viscous friction that its model lacks; readings with encoder noise."""
    (folder / "trajectories").mkdir(parents=True)
    (folder / "measurement.yaml").write_text(SPEC)
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 2.5, 0.01)

    def change(_: float, state: np.ndarray) -> list[float]:
        return [state[1], (-0.2 * 9.81 * 0.1 * np.sin(state[0]) - DAMPING * state[1]) / 0.01]

    for k in range(trials):
        start = [rng.uniform(0.5, 1.5) * (-1) ** k, 0.0]
        truth = solve_ivp(change, (0.0, t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-9).y[0]
        table = np.stack([t, truth + 5e-4 * rng.normal(size=len(t))], axis=1)
        np.savetxt(folder / "trajectories" / f"s{k}.csv", table, delimiter=",", header="t,angle", comments="")
    return folder


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("gap")
    measurement, out = swings(folder / "door"), folder / "out"
    result = RUN.invoke(app, ["gap", "find", str(measurement), "--out", str(out)])
    assert result.exit_code == 0, result.output
    return measurement, out


def report(out: Path) -> GapReport:
    return GapReport.model_validate_json((out / "report.json").read_bytes())


def test_a_hidden_effect_is_named_with_its_size(answered: tuple[Path, Path]):
    verdict = report(answered[1]).verdict
    assert verdict.status == "effect_found", verdict.statement
    (effect,) = [e for e in verdict.effects if e.confidence >= 0.8]
    assert effect.name == "joint.viscous_friction"
    assert effect.parameters["damping_Nms_per_rad"].value == pytest.approx(DAMPING, rel=0.1)


def test_conventions_error_places_and_steps_are_reported(answered: tuple[Path, Path]):
    said = report(answered[1])
    states = {t.name: t.status for t in said.traps}
    assert states["joint_motor_and_damping_off"] == states["joint_inertia_held"] == states["step_size"] == "ok"
    assert said.localisation
    assert all(row.contrast is not None and row.contrast >= POLICY.contrast for row in said.localisation)
    assert "door: fast" in said.localisation[0].what  # The hidden friction is viscous.
    assert [s.name for s in said.ladder][:2] == ["declared", "null_refit"]
    assert said.ladder[-2].heldout < 0.5 * said.ladder[0].heldout


def test_engine_and_step_are_reported_beside_the_users(answered: tuple[Path, Path]):
    """A swing at 1/240 s: the engine's part is there, and far below the gap that the friction makes."""
    said, page = report(answered[1]), (answered[1] / "report.html").read_text()
    assert said.rollout is not None
    assert said.rollout.name == "Mana"
    comparison = said.engine_comparison
    assert comparison is not None
    assert comparison.engine.step_s == pytest.approx(1.0 / 240.0)
    (joint,) = comparison.differences
    assert 0.0 < joint.between_engines < 0.3 * joint.ours_to_recording
    assert comparison.engine.name in page
    assert "Whose error" in page


def test_the_page_needs_no_other_file(answered: tuple[Path, Path]):
    page = (answered[1] / "report.html").read_text()
    assert "<title>Sim gap: door</title>" in page
    assert "<h1>Sim gap: door</h1>" in page
    assert page.count("data:image/png;base64,") == 4
    assert "http" not in page.replace("data:image", "")
    assert "joint.viscous_friction" in page


def test_each_candidate_has_a_reason_on_file_and_page(answered: tuple[Path, Path]):
    """Reasons of a real run agree with the values beside them; a swapped one does not."""
    result, page = report(answered[1]), (answered[1] / "report.html").read_text()
    assert contradictions(result) == []
    names = {(h.name, str(h.where)) for h in result.hypotheses}
    assert names <= {(d.name, str(d.where)) for d in result.decisions}
    assert all(row.reason in page and row.value.split(",")[0] in page for row in decision_rows(result.decisions))
    first, *others = result.decisions
    reason = next(d.reason for d in others if d.reason is not first.reason)
    swapped = (first.model_copy(update={"reason": reason}), *others)
    assert contradictions(result.model_copy(update={"decisions": swapped}))


def test_the_page_is_rendered_again_from_the_report(answered: tuple[Path, Path]):
    page = answered[1] / "report.html"
    before = page.read_bytes()
    page.unlink()
    assert RUN.invoke(app, ["gap", "report", str(answered[1])]).exit_code == 0
    assert page.read_bytes() == before


def test_the_same_folder_gives_the_same_bytes(answered: tuple[Path, Path], tmp_path: Path):
    again = RUN.invoke(app, ["gap", "find", str(answered[0]), "--out", str(tmp_path), "--jobs", "2", "--json"])
    assert again.exit_code == 0
    files = ["extension.json", *(f"pictures/{n}.png" for n in ("overlay", "ladder", "unexplained", "engines"))]
    assert all((tmp_path / f).read_bytes() == (answered[1] / f).read_bytes() for f in files)
    one, two = (report(f).model_copy(update={"wall_s": 0.0}) for f in (answered[1], tmp_path))
    assert one == two


def test_the_extension_brings_the_simulation_to_the_readings(answered: tuple[Path, Path], tmp_path: Path):
    extension = answered[1] / "extension.json"
    command = ["gap", "simulate", str(answered[0]), "--extension", str(extension), "--out", str(tmp_path), "--json"]
    result = RUN.invoke(app, command)
    assert result.exit_code == 0, result.output
    rmse = {(r["view"], r["model"]): r["rmse"] for r in json.loads((tmp_path / "errors.json").read_text())["errors"]}
    assert rmse["full_rollout", "extended"] < 0.1 * rmse["full_rollout", "declared"]
    table = np.genfromtxt(tmp_path / "trajectories" / "s0.csv", delimiter=",", names=True)
    assert table.dtype.names == ("t", "q_door_measured", "q_door_declared", "q_door_extended")
    assert np.abs(table["q_door_extended"] - table["q_door_measured"]).max() < 0.03


def test_an_extension_for_another_mechanism_is_refused(answered: tuple[Path, Path], tmp_path: Path):
    other = tmp_path / "extension.json"
    other.write_text((answered[1] / "extension.json").read_text().replace('"door"', '"drawer"'))
    command = ["gap", "simulate", str(answered[0]), "--extension", str(other), "--out", str(tmp_path)]
    refused = RUN.invoke(app, command).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == "gap/unknown-place"


def test_what_cannot_be_searched_yet_says_so(tmp_path: Path):
    folder = swings(tmp_path / "arm", trials=3)
    tracked = "  urdf: arm.urdf\n  end_effector: b\n  controller: {type: stable_pd, kp: 100, kd: 10}\n"
    spec = SPEC.split("  joints")[0].replace("kind: mechanism", "kind: tracking")
    (folder / "measurement.yaml").write_text(
        spec.replace("q_door: angle", "q_door: angle, command_door: angle") + tracked
    )
    (folder / "arm.urdf").write_text(DOOR_URDF)
    refused = RUN.invoke(app, ["gap", "find", str(folder), "--out", str(tmp_path / "out")]).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == "gap/kind-unsupported-yet"


def test_a_subject_that_cannot_be_built_yet_says_so(tmp_path: Path):
    folder = swings(tmp_path / "urdf", trials=3)
    (folder / "door.urdf").write_text(DOOR_URDF)
    (folder / "measurement.yaml").write_text(SPEC.split("  joints")[0] + "  urdf: door.urdf\n")
    refused = RUN.invoke(app, ["gap", "find", str(folder), "--out", str(tmp_path / "out")]).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == "gap/subject-unsupported-yet"


def test_a_folder_that_cannot_be_read_ends_with_code_1(tmp_path: Path):
    folder = SAMPLES["gap/missing-key"](tmp_path / "bad")
    result = RUN.invoke(app, ["gap", "find", str(folder), "--out", str(tmp_path / "out"), "--json"])
    assert result.exit_code == 1
    assert json.loads(result.output)["diagnostics"][0]["code"] == "gap/missing-key"


def test_effects_are_listed_and_explained():
    assert len(json.loads(RUN.invoke(app, ["gap", "effects", "--json"]).output)) >= 40
    text = RUN.invoke(app, ["gap", "effects", "joint.backlash"]).output
    assert "gap_rad" in text
    refused = RUN.invoke(app, ["gap", "effects", "joint.magnetism"]).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == "gap/unknown-effect"


def _silent(words: str, done: int = 0, total: int | None = None) -> None:
    """A Tick that prints nothing."""


def test_the_demo_finds_what_it_hides_and_shows_it(tmp_path: Path):
    gap = gap_demo(tmp_path, jobs=1, tick=_silent)
    (named,) = gap.report.verdict.effects
    assert named.name == "joint.coulomb_friction"
    low, high = named.parameters["torque_Nm"].ci95
    assert low < FRICTION_NM < high
    shown = _pictures(tmp_path, gap)
    assert len(shown) == 3
    assert all((tmp_path / place).is_file() for _, place in shown)


def test_an_answer_is_given_again_at_once_and_only_for_the_same_input(
    answered: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(answered[0].parent)
    command = ["gap", "find", answered[0].name, "--out", str(answered[1]), "--json"]
    before = {p: p.read_bytes() for p in answered[1].rglob("*") if p.is_file()}
    again = RUN.invoke(app, command)
    assert again.exit_code == 0
    assert json.loads(again.output) == json.loads((answered[1] / "report.json").read_text())
    assert {p: p.read_bytes() for p in answered[1].rglob("*") if p.is_file()} == before  # wall_s too: nothing was run
    store = ResultStore(answered[1], json.loads((answered[1] / ".cache" / "answer.json").read_text())["key"])
    assert store.answered()
    assert not replace(store, key="other").answered()
    page = answered[1] / "report.html"
    page.write_text("edited")
    assert not store.answered()
    page.write_bytes(before[page])


def test_an_interrupted_run_continues_with_what_was_finished(answered: tuple[Path, Path], tmp_path: Path):
    measurement = read(answered[0]).value
    assert measurement is not None

    def cut(words: str, done: int = 0, total: int | None = None) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search(measurement, (), tmp_path, engine=REPLAY_ENGINE, jobs=1, tick=cut, since=0.0, quick=True)
    parts = sorted(tmp_path.rglob("*.bin"))
    assert len(parts) == 4  # conventions, places, two candidates
    assert not (tmp_path / "report.json").exists()
    store = ResultStore(tmp_path, answer_key(measurement, quick=True))
    assert isinstance(store.part("traps", lambda: pytest.fail("worked out again")), tuple)
    parts[0].write_bytes(b"damaged")
    resumed = search(measurement, (), tmp_path, engine=REPLAY_ENGINE, jobs=1, tick=_silent, since=0.0, quick=True)
    assert resumed.hypotheses == report(answered[1]).hypotheses
    assert resumed.verdict == report(answered[1]).verdict
    assert not list(tmp_path.rglob("*.bin"))
    rivals = {r.name: r.heldout for r in report(answered[1]).baselines}
    assert [r.name for r in resumed.baselines] == [n for n in rivals if n != "all_effects"]
    assert rivals["black_box"] < rivals["null_refit"]  # On top of the named effect.
    assert rivals["all_effects"] > rivals["black_box"]  # All at once fit worse than the one that acts.


def test_a_stored_part_from_elsewhere_runs_nothing(tmp_path: Path):
    class Evil:
        def __reduce__(self) -> tuple:
            return (Path.touch, (tmp_path / "owned",))

    store = ResultStore(tmp_path, "key")
    store.part("x", lambda: 1)
    (file,) = tmp_path.rglob("*.bin")
    file.write_bytes(zlib.compress(pickle.dumps(Evil())))
    assert store.part("x", lambda: 2) == 2
    assert not (tmp_path / "owned").exists()
