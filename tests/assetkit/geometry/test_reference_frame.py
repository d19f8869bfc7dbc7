"""Semantics gives scale and pose once; unit and axis that the user states are kept."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetkit.options import Options
from assetkit.pipeline import STAGES, run_stages
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Tools
from assetkit.stage_log import StageLog
from assetkit.stages.intake import ReadSource
from jobs.cache import Cache
from schemas.arrays import FloatArray
from sim.fake import FakeSimulator
from tests.support.bad_inputs.assets import LYING_CUP, obj_text

TALL_M = 0.095


def described(folder: Path, name: str, mesh: trimesh.Trimesh, head: str = "", **stated) -> tuple[Draft, StageLog]:
    """The draft and its journal after the stages that observe and describe."""
    (folder / name).write_text(obj_text(mesh, head))
    options, log = Options(**stated), StageLog()
    draft = Draft("part", name, ReadSource().run(discover([folder / name])[0], options).objects[0])
    tools = Tools(FakeSimulator(), folder, options)
    done = run_stages(draft, tools, log, Cache(folder / "store"), "key", STAGES.up_to("semantics"))
    assert done is not None
    return done, log


def extent(draft: Draft) -> FloatArray:
    assert draft.canonicalize is not None
    return np.ptp(np.concatenate([m.points for m in draft.canonicalize.meshes]), axis=0)


def scaled(factor: float) -> trimesh.Trimesh:
    return trimesh.Trimesh(LYING_CUP.vertices * factor, LYING_CUP.faces)


@pytest.mark.parametrize(
    ("factor", "error"), [(1000.0, 1e-6), (100.0, 1e-6), (1.0 / 0.0254, 1e-6), (1.0 / TALL_M, 0.3)]
)
def test_a_lying_mug_without_a_unit_ends_upright_in_its_size(tmp_path: Path, factor: float, error: float) -> None:
    draft, log = described(tmp_path, "mug.obj", scaled(factor))
    assert extent(draft)[2] == pytest.approx(TALL_M, rel=error)
    assert draft.canonicalize is not None
    unit = draft.canonicalize.meters_per_unit
    low, high = unit.bounds or (unit.value, unit.value)
    assert low * (1 - 1e-9) <= 1.0 / factor <= high * (1 + 1e-9)
    assert unit.source == "inferred"
    assert "asset/turned-upright" in [d.code for d in log.diagnostics]
    assert {"turn_upright"} <= {r.name for r in log.repairs}


def test_the_opening_is_up_and_normals_go_with_it(tmp_path: Path) -> None:
    draft, _ = described(tmp_path, "mug.obj", scaled(1000.0))
    assert draft.canonicalize is not None
    solid = draft.canonicalize.solid
    corners = solid.points[solid.triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    top = np.isclose(corners[:, :, 2], TALL_M, atol=1e-6).all(axis=1)
    assert facing[top, 2].min() > 0.0
    assert 0.5 * facing[top, 2].sum() < 0.5 * np.pi * 0.04**2  # A rim, no lid.


def test_what_the_user_says_is_never_changed(tmp_path: Path) -> None:
    draft, log = described(tmp_path, "mug.obj", scaled(1000.0), units="m", up_axis="z")
    assert extent(draft).max() == pytest.approx(1000.0 * TALL_M)
    assert draft.frame is None
    assert "asset/category-contradicted" in [d.code for d in log.diagnostics]


def test_a_unit_in_the_texts_is_never_changed(tmp_path: Path) -> None:
    draft, _ = described(tmp_path, "mug.obj", scaled(10.0), "# units: m\n")
    assert extent(draft).max() == pytest.approx(10.0 * TALL_M)


def test_an_unknown_normalised_thing_keeps_its_numbers_and_goes_to_a_person(tmp_path: Path) -> None:
    draft, log = described(tmp_path, "part.obj", scaled(1.0 / TALL_M))
    assert draft.canonicalize is not None
    unit = draft.canonicalize.meters_per_unit
    assert (unit.value, unit.confidence) == (1.0, 0.0)
    assert unit.bounds is not None
    assert unit.bounds[0] < TALL_M < unit.bounds[1]
    assert any(e.review for e in log.entries.values())


def test_geometry_is_observed_once_more_and_never_again(tmp_path: Path) -> None:
    draft, log = described(tmp_path, "mug.obj", scaled(1000.0))
    tools = Tools(FakeSimulator(), tmp_path, Options())
    again = run_stages(
        draft, tools, log, Cache(tmp_path / "store"), "other", STAGES.up_to("semantics").from_stage("semantics")
    )
    assert again is not None
    assert again.canonicalize is draft.canonicalize
