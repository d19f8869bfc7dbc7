"""Parts: which triangles they hold, as text and back."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
from hypothesis import given

from schemas.parts import part_faces


@given(st.sets(st.integers(0, 200)))
def test_triangles_come_back_from_their_text(chosen: set[int]) -> None:
    """Any set of triangles is the same after it was written down."""
    faces = part_faces("cup", sorted(chosen, reverse=True))
    assert faces.indices.tolist() == sorted(chosen)


def test_runs_are_written_short() -> None:
    """A person can read which triangles a part has."""
    assert part_faces("cup", np.array([0, 1, 2, 7, 9, 10])).ranges == "0-2 7 9-10"
