"""The user's statements win, what follows from a category has its confidence, and unknown is no reason to stop."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Tools
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.stages.semantics import DescribeObject
from schemas.asset import SemanticsSection
from schemas.outcome import Outcome
from sim.fake import FakeSimulator
from tests.support.bad_inputs.assets import CUBE, obj_text

TUBE = trimesh.creation.revolve(
    np.array([[0, 0], [0.04, 0], [0.04, 0.09], [0.036, 0.09], [0.036, 0.005], [0, 0.005]]), sections=48
)


def described(folder: Path, name: str, mesh: trimesh.Trimesh = TUBE, **stated) -> Outcome:
    """The outcome of the stage for a file `name` in a folder whose name says nothing."""
    place = folder / "assets"
    place.mkdir(exist_ok=True)
    (place / name).write_text(obj_text(mesh, "# units: m, z up\n"))
    options = Options(units="m", up_axis="z", **stated)
    draft = Draft("part", name, ReadSource().run(discover([place / name])[0], options).objects[0])
    tools = Tools(FakeSimulator(), folder, options)
    return DescribeObject().run(replace(draft, canonicalize=Canonicalize().run(draft, tools).value), tools)


def section(outcome: Outcome) -> SemanticsSection:
    assert outcome.value is not None
    return outcome.value.section


def codes(outcome: Outcome) -> list[str]:
    return [d.code for d in outcome.diagnostics]


def test_a_named_vessel(tmp_path: Path):
    outcome = described(tmp_path, "025_mug.obj")
    found = section(outcome)
    assert (found.category.value, found.category.source) == ("mug", "inferred")
    assert found.family.value == "drinkware"
    assert (found.qcode.value, found.qcode.confidence) == ("Q386215", found.category.confidence)
    assert [r.value for r in found.roles] == ["manipulated", "receptacle"]
    assert "025_mug" in found.source_texts
    assert codes(outcome) == []


def test_silent_names_are_told_and_only_reviewed_on_demand(tmp_path: Path):
    outcome = described(tmp_path, "part.obj")
    assert (section(outcome).category.value, section(outcome).category.confidence) == ("unknown", 0.0)
    assert section(outcome).roles == ()
    assert codes(outcome) == ["asset/category-unknown"]
    assert not outcome.review
    assert described(tmp_path, "part.obj", require_category=True).review
    assert not described(tmp_path, "mug.obj", require_category=True).review


def test_a_mug_of_three_metres(tmp_path: Path):
    outcome = described(tmp_path, "mug.obj", trimesh.creation.box((2.0, 2.0, 3.0)))
    assert section(outcome).category.value == "unknown"
    assert codes(outcome).count("asset/category-contradicted") >= 1
    assert section(outcome).hypotheses[0].category == "mug"


@pytest.mark.parametrize(("said", "known"), [("bowl", "bowl"), ("Mugs", "mug")])
def test_the_user_is_believed_and_an_alias_is_kept_under_its_name(tmp_path: Path, said: str, known: str):
    found = section(described(tmp_path, "025_mug.obj", category=said, role="tool"))
    assert (found.category.value, found.category.source) == (known, "declared")
    assert found.family.confidence == 1.0
    assert [r.value for r in found.roles] == ["tool"]


def test_the_user_is_told_what_speaks_against_it(tmp_path: Path):
    assert "asset/category-contradicted" in codes(described(tmp_path, "025_mug.obj", category="plate"))
    assert codes(described(tmp_path, "025_mug.obj", category="mug")) == []


def test_a_category_of_the_users_own(tmp_path: Path):
    outcome = described(tmp_path, "part.obj", CUBE, category="armadillo")
    assert section(outcome).category.value == "armadillo"
    assert section(outcome).family.value == "unknown"
    assert codes(outcome) == ["asset/category-outside-vocabulary"]


def test_a_part_of_a_family_gets_the_more_general_class(tmp_path: Path):
    found = section(described(tmp_path, "part.obj", category="screwdriver"))
    assert found.qcode.value == "Q39546"
    assert "more general" in found.qcode.method
