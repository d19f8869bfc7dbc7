"""Obstacles that a failure picture shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from benchmarks.scenes.workload import box_body
from scenec.ir.problem import Exhausted, Infeasible, Placement, Proof
from scenec.pictures.blockers import footprint, obstructing_things, owner_parts
from scenec.pictures.failure import failure
from schemas.scene.geometry import Prism
from tests.scenec.solve.test_solver_scenes import problem, thing

LAMP, BOOK, CUP = (thing(name, box_body(name, 0.1, 0.2)) for name in ("lamp", "book", "cup"))
FIXED = replace(LAMP, domain=replace(LAMP.domain, x_m=(0.3, 0.3), y_m=(0.1, 0.1), yaw_rad=(np.pi / 2, np.pi / 2)))
PROOF = Infeasible(Proof("infeasible", "no room", 0.0, 1.0, "", ()))


def test_what_can_stand_in_one_place_only_is_in_the_way():
    given = problem(FIXED, BOOK)
    ((found, at),) = obstructing_things(given, PROOF, FIXED.parent, FIXED.place.name)
    assert found.name == "lamp"
    assert footprint(found, at).bounds == pytest.approx((0.2, 0.05, 0.4, 0.15))


def test_after_a_search_without_an_answer_all_that_stood_is_in_the_way_but_the_one_that_failed():
    stood = {"book": Placement(0.0, 0.0, 0.0, 0), "cup": Placement(0.3, 0.0, 0.0, 0)}
    result = Exhausted(2, 3, "cup", 10, stood)
    given = problem(LAMP, BOOK, CUP)
    assert [item.name for item, _ in obstructing_things(given, result, BOOK.parent, BOOK.place.name)] == ["book"]
    assert failure(given, result).startswith(b"\x89PNG")


def test_rims_and_posts_of_the_owner_are_in_the_way():
    post = Prism(np.array([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)]), 0.0, 0.3)
    given = problem(replace(BOOK, place=replace(BOOK.place, above=(post,))))
    (part,) = owner_parts(given, BOOK.parent, BOOK.place.name)
    assert part.equals(shapely.box(-0.1, -0.1, 0.1, 0.1))
