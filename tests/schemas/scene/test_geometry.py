"""Prisms in documents: lists of points in JSON, arrays in Python, equal by their content."""

from __future__ import annotations

import json

import numpy as np
import pytest
from pydantic import ValidationError

from schemas.scene.geometry import Prism, rounded_value
from schemas.scene.runtime_plan import PlanStance

TEXT = json.dumps(
    {
        "name": "upright",
        "quat_wxyz": [1.0, 0.0, 0.0, 0.0],
        "origin_height_m": 0.1,
        "prisms": [{"outline_m": [[0.0, 0.0], [0.2, 0.0], [0.0, 0.3]], "low_m": 0.0, "high_m": 0.5}],
    },
    separators=(",", ":"),
)


def test_a_document_is_read_into_arrays_and_written_to_the_same_bytes() -> None:
    stance = PlanStance.model_validate_json(TEXT)
    (prism,) = stance.prisms
    assert isinstance(prism, Prism)
    assert prism.outline_m.dtype == np.float64
    assert prism.outline_m.tolist() == [[0.0, 0.0], [0.2, 0.0], [0.0, 0.3]]
    assert stance.model_dump_json() == TEXT
    assert json.loads(TEXT) == stance.model_dump(mode="json")


def test_equal_prisms_are_one_key() -> None:
    one, two = (PlanStance.model_validate_json(TEXT) for _ in range(2))
    other = PlanStance.model_validate_json(TEXT.replace("0.3", "0.31"))
    assert one == two
    assert one != other
    assert hash(one) == hash(two)


@pytest.mark.parametrize(("written", "wrong"), [("[0.2,0.0]", '["x",0.0]'), ("[0.2,0.0]", "[0.2]")])
def test_a_wrong_point_is_named_by_its_place(written: str, wrong: str) -> None:
    with pytest.raises(ValidationError) as refused:
        PlanStance.model_validate_json(TEXT.replace(written, wrong))
    assert refused.value.errors()[0]["loc"][:4] == ("prisms", 0, "outline_m", 1)


def test_rounding_is_to_nanometres_without_negative_zero() -> None:
    prism = Prism(np.array([(1e-10, 1.0000000004)]), -1e-12, 0.1 + 0.2).rounded()
    assert json.dumps([prism.outline_m.tolist(), prism.low_m, prism.high_m]) == "[[[0.0, 1.0]], 0.0, 0.3]"
    assert json.dumps(rounded_value(-0.0)) == "0.0"
