"""What is screened out: by clear names and by size, never against a category, never a toy."""

from __future__ import annotations

from pathlib import Path

import pytest

from assetkit.annotate.annotator import ObjectShape, Observation
from assetkit.annotate.domain import out_of_domain
from assetkit.annotate.embedded import EmbeddedAnnotator
from benchmarks.assets.semantics import observed


def reason_for(file: str, extents_m=(1.4, 1.8, 4.5), *, metric=True, folders=(), nodes=()) -> str:
    shape = ObjectShape(extents_m, None, None, metric)
    seen = Observation(file, folders, nodes, (), (), shape)
    return out_of_domain(seen, EmbeddedAnnotator().annotate(seen))


@pytest.mark.parametrize(
    ("file", "domain"),
    [
        ("sedan", "vehicle"),
        ("police_car_v2", "vehicle"),
        ("chr_knight", "character"),
        ("bathroom_01", "room or building"),
        ("house", "room or building"),
        ("cloth_z_up", "deformable"),
    ],
)
def test_clear_names_are_screened(file: str, domain: str):
    assert domain in reason_for(file)
    assert domain in reason_for(file, (1.0, 2.0, 3.0), metric=False)


@pytest.mark.parametrize("file", ["car_door", "fish_tank", "bird_house", "kitchen_cart", "gravy_boat"])
def test_names_of_other_things_are_not(file: str):
    assert not reason_for(file, (0.1, 0.2, 0.3))


def test_what_is_known_to_be_small_is_a_toy_but_cloth_is_cloth():
    assert not reason_for("car", (0.03, 0.05, 0.1))
    assert not reason_for("dinosaur", (0.03, 0.05, 0.1))
    assert "deformable" in reason_for("towel", (0.01, 0.05, 0.1))


def test_a_category_wins_and_nodes_do_not_speak():
    assert not reason_for("dog_bowl", (0.05, 0.15, 0.15))
    assert not reason_for("scene_7", (0.5, 0.5, 0.5), nodes=("car", "truck"))


def test_silent_names_are_screened_by_size_and_by_their_folder():
    assert "larger than what stands in a room" in reason_for("mesh_0")
    assert not reason_for("mesh_0", (1.3, 1.8, 4.5))
    assert not reason_for("mesh_0", metric=False)
    assert "vehicle" in reason_for("mesh_0", (1.0, 2.0, 3.0), folders=("truck",))


def test_a_real_file_of_cloth_is_screened_and_one_of_a_table_is_not(bullet_data: Path):
    for file, domain in (("cloth_z_up.obj", "deformable"), ("table/table.obj", "")):
        seen = observed(bullet_data / file)
        assert seen is not None
        reason_for = out_of_domain(seen, EmbeddedAnnotator().annotate(seen))
        assert domain in reason_for
        assert bool(reason_for) == bool(domain)
