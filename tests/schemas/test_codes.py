"""Table of codes, documentation pages and smallest bad inputs agree."""

from dataclasses import replace
from pathlib import Path

import pytest

from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Tools
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.semantics import DescribeObject
from cli.codes import all_codes
from cli.docs.diagnostics import file_name, index, page
from dsl.task_file import read_task
from formats import read_mjcf, read_urdf
from replay.recording.formats.read import read_episodes
from runtime_plan import load
from scenec.bind.asset_library import AssetLibrary
from scenec.bind.components import lower
from scenec.compile import compile_program
from scenec.source.read import read_program
from schemas.codes import CODES
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from sim.fake import FakeSimulator
from simgap.recording.read import read
from tests.support.bad_inputs import gap, replay, robot, scene
from tests.support.bad_inputs import plan as plan_bad_inputs
from tests.support.bad_inputs import task as task_bad_inputs
from tests.support.bad_inputs.assets import SAMPLES
from tests.support.bad_inputs.assets_without_a_file import NOT_FROM_A_FILE
from tests.support.scene import library as scene_library

PAGES = Path(__file__).parents[2] / "docs" / "diagnostics"
GAP, SCENE, PLAN, REPLAY, ROBOT, TASK = "gap/", "scene/", "plan/", "replay/", "robot/", "task/"
PIPELINE = "pipeline/"  # tests/dsl/test_pipeline_file.py


def findings(file: Path, options: Options) -> list[Diagnostic]:
    """What the stages up to semantics say about a file, and physics where the source states some."""
    taken = ReadSource().run(discover([file])[0], options)
    diagnostics = list(taken.diagnostics)
    for item in taken.objects[:1]:
        draft = Draft("part", file.name, item)
        tools = Tools(FakeSimulator(), file.parent, options)
        canonical = Canonicalize().run(draft, tools)
        diagnostics += canonical.diagnostics
        if canonical.value is not None:
            draft = replace(draft, canonicalize=canonical.value)
            diagnostics += NormalizeAppearance().run(draft, tools).diagnostics
            described = DescribeObject().run(draft, tools)
            diagnostics += described.diagnostics
            diagnostics += ProposeParts().run(replace(draft, semantics=described.value), tools).diagnostics
            if described.value is not None and described.value.frame is not None:
                diagnostics += Canonicalize().run(replace(draft, frame=described.value.frame), tools).diagnostics
        if canonical.value is not None and (item.model.masses or item.model.contacts):
            diagnostics += AuthorPhysics().run(replace(draft, canonicalize=canonical.value), tools).diagnostics
    return diagnostics


def test_every_code_has_a_sample():
    areas = (GAP, SCENE, PLAN, REPLAY, ROBOT, TASK, PIPELINE)
    assert {*SAMPLES, *NOT_FROM_A_FILE} == {c for c in CODES if not c.startswith(areas)}
    assert not set(SAMPLES) & set(NOT_FROM_A_FILE)


def test_every_gap_code_has_a_sample():
    samples, others = set(gap.SAMPLES), set(gap.NOT_FROM_A_FOLDER)
    assert samples | others == {c for c in CODES if c.startswith(GAP)}
    assert not samples & others


def test_every_scene_code_has_a_sample():
    groups = (scene.SAMPLES, scene.BOUND, scene.VERDICTS)
    assert sorted(code for group in groups for code in group) == sorted(c for c in CODES if c.startswith(SCENE))


def test_every_plan_code_has_a_sample():
    samples, others = set(plan_bad_inputs.SAMPLES), set(plan_bad_inputs.NOT_FROM_A_PLAN)
    assert samples | others == {c for c in CODES if c.startswith(PLAN)}
    assert not samples & others


def test_every_task_code_has_a_sample():
    samples, others = set(task_bad_inputs.SAMPLES), set(task_bad_inputs.NOT_FROM_A_TASK)
    assert samples | others == {c for c in CODES if c.startswith(TASK)}
    assert not samples & others


@pytest.mark.parametrize("code", sorted(task_bad_inputs.SAMPLES))
def test_task_sample_triggers_its_code_alone_with_place_and_help(code: str, tmp_path: Path):
    _, diagnostics = read_task(task_bad_inputs.write(task_bad_inputs.SAMPLES[code], tmp_path))
    assert [d.code for d in diagnostics] == [code]
    assert diagnostics[0].where.line
    assert diagnostics[0].help == CODES[code].help


def test_every_robot_code_has_a_sample():
    samples, others = set(robot.SAMPLES), set(robot.NOT_FROM_A_DESCRIPTION)
    assert samples | others == {c for c in CODES if c.startswith(ROBOT)}
    assert not samples & others


@pytest.mark.parametrize("code", sorted(robot.SAMPLES))
def test_robot_sample_triggers_its_code_with_file_line_and_help(code: str, tmp_path: Path):
    path = robot.write(robot.SAMPLES[code], tmp_path)
    read_file = read_urdf if path.suffix == ".urdf" else read_mjcf
    try:
        findings_of_file = read_file(path).notes
    except InvalidInput as refused:
        findings_of_file = (refused.diagnostic,)
    (diagnostic,) = [d for d in findings_of_file if d.code == code]
    assert diagnostic.headline
    assert diagnostic.where.file == path.name
    assert diagnostic.where.line
    assert diagnostic.help == CODES[code].help


def test_every_replay_code_has_a_sample():
    samples, others = set(replay.SAMPLES), set(replay.NOT_FROM_A_RECORDING)
    assert samples | others == {c for c in CODES if c.startswith(REPLAY)}
    assert not samples & others


@pytest.mark.parametrize("code", sorted(replay.SAMPLES))
def test_replay_sample_is_refused_with_its_code_place_and_help(code: str, tmp_path: Path):
    with pytest.raises(InvalidInput) as refused:
        read_episodes(replay.SAMPLES[code](tmp_path))
    assert refused.value.diagnostic.code == code
    assert refused.value.diagnostic.headline
    assert refused.value.diagnostic.where.file
    assert refused.value.diagnostic.help == CODES[code].help


@pytest.mark.parametrize("code", sorted(plan_bad_inputs.SAMPLES))
def test_plan_sample_is_refused_with_its_code_place_and_help(code: str, tmp_path: Path):
    plan, packages = plan_bad_inputs.write(code, tmp_path)
    with pytest.raises(InvalidInput) as refused:
        load(plan, packages)
    assert refused.value.diagnostic.code == code
    assert refused.value.diagnostic.headline
    assert refused.value.diagnostic.help == CODES[code].help


@pytest.mark.parametrize("code", sorted(scene.SAMPLES))
def test_scene_sample_triggers_its_code_alone_with_place_and_help(code: str, tmp_path: Path):
    found = read_program(scene.write(scene.SAMPLES[code], tmp_path)).diagnostics
    assert [d.code for d in found] == [code]
    assert found[0].where.line
    assert found[0].help == CODES[code].help


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(scene_library.library(tmp_path_factory.mktemp("library")))


@pytest.mark.parametrize("code", sorted(scene.BOUND))
def test_scene_sample_triggers_its_code_once_assets_are_known(code: str, tmp_path: Path, library: AssetLibrary):
    read = read_program(scene.write(scene.BOUND[code], tmp_path))
    assert read.program is not None, read.diagnostics
    found = lower(read.program, library, read.spans).diagnostics
    assert [d.code for d in found] == [code]
    assert found[0].where.line


@pytest.mark.parametrize("code", sorted(scene.VERDICTS))
def test_scene_sample_without_a_scene_ends_in_its_verdict(code: str, tmp_path: Path):
    path = scene.write(scene.VERDICTS[code], tmp_path)
    compiled = compile_program(path, explain=False, budget=200)
    assert [d.code for d in compiled.report.diagnostics] == [code]
    assert not compiled.scenes


ELSEWHERE = (
    NOT_FROM_A_FILE
    | gap.NOT_FROM_A_FOLDER
    | plan_bad_inputs.NOT_FROM_A_PLAN
    | replay.NOT_FROM_A_RECORDING
    | robot.NOT_FROM_A_DESCRIPTION
    | task_bad_inputs.NOT_FROM_A_TASK
)


@pytest.mark.parametrize(("code", "test"), sorted(ELSEWHERE.items()))
def test_codes_without_a_file_are_named_in_their_test(code: str, test: str):
    assert code in (Path(__file__).parents[2] / test).read_text()


@pytest.mark.parametrize("code", sorted(SAMPLES))
def test_sample_triggers_its_code_with_place_and_help(code: str, tmp_path: Path):
    options = Options(max_triangles=1000, max_texture=16)
    found = [d for d in findings(SAMPLES[code](tmp_path), options) if d.code == code]
    assert found, f"{code} was not reported"
    assert found[0].headline
    assert found[0].help == CODES[code].help


@pytest.mark.parametrize("code", sorted(gap.SAMPLES))
def test_gap_sample_triggers_its_code_with_place_and_help(code: str, tmp_path: Path):
    found = {d.code: d for d in read(gap.SAMPLES[code](tmp_path)).diagnostics}
    assert code in found
    assert found[code].headline
    assert found[code].where.file
    assert found[code].help == CODES[code].help


def test_pages_are_generated_from_the_table():
    assert {p.name: p.read_text() for p in PAGES.glob("*.md")} == {
        **{file_name(code): page(code, info) for code, info in all_codes().items()},
        "index.md": index(),
    }


def test_an_unknown_code_cannot_be_used():
    with pytest.raises(KeyError):
        finding("asset/no-such-code", "nothing")
