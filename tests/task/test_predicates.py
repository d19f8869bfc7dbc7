"""Every predicate holds for what fulfils it, not for what almost does or tries to deceive, in one piece and in any."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from schemas.arrays import BoolArray
from schemas.task.state_log import StateLog
from task.frames import Frames, StateMissing
from task.predicates.protocol import CHANNELS, Predicate
from task.predicates.table import PREDICATES, predicate_from
from tests.task.samples import SAMPLES, Sample
from tests.task.world import SCENE, logged

LABELS = [f"{each.func}: {each.why}" for each in SAMPLES]


def values_of(predicate: Predicate, sample: Sample, cuts: tuple[int, ...] = ()) -> BoolArray:
    """Values over the whole log, asked in pieces that end at the cuts."""
    carry, pieces = predicate.start(), list[BoolArray]()
    bounds = [0, *sorted({c for c in cuts if 0 < c < len(sample.log)}), len(sample.log)]
    for first, last in pairwise(bounds):
        values, carry = predicate.values(Frames(sample.log, SCENE, first, last), carry)
        pieces.append(values)
    return np.concatenate(pieces)


@pytest.mark.parametrize("sample", SAMPLES, ids=LABELS)
def test_a_sample_holds_exactly_when_it_is_true(sample: Sample) -> None:
    assert sample.log.faults() == []
    assert bool(values_of(predicate_from(sample.written), sample)[-1]) == (sample.kind == "true")


@pytest.mark.parametrize("sample", SAMPLES, ids=LABELS)
@settings(max_examples=12, deadline=None)
@given(cuts=st.lists(st.integers(1, 59), max_size=6).map(tuple))
def test_pieces_of_a_log_give_the_values_of_the_whole(sample: Sample, cuts: tuple[int, ...]) -> None:
    predicate = predicate_from(sample.written)
    assert values_of(predicate, sample, cuts).tolist() == values_of(predicate, sample).tolist()


@pytest.mark.parametrize("func", PREDICATES)
def test_every_predicate_has_samples_of_each_kind(func: str) -> None:
    kinds = {sample.kind for sample in SAMPLES if sample.func == func}
    assert kinds == {"true", "almost", "hostile"}


@pytest.mark.parametrize("sample", SAMPLES, ids=LABELS)
def test_a_predicate_reads_the_channels_that_it_names_and_no_other(sample: Sample) -> None:
    predicate = predicate_from(sample.written)
    channels = predicate.channels()
    assert channels <= set(CHANNELS)
    if not channels & {"contacts", "grippers"}:
        bare = Sample(sample.written, sample.kind, sample.why, without(sample, "touching"))
        assert values_of(predicate, bare).tolist() == values_of(predicate, sample).tolist()
    if "joints" not in channels:
        bare = Sample(sample.written, sample.kind, sample.why, without(sample, "joint_position"))
        assert values_of(predicate, bare).tolist() == values_of(predicate, sample).tolist()


def without(sample: Sample, channel: str) -> StateLog:
    """The log without its contacts or joints."""
    if channel == "touching":
        return replace(sample.log, touching=None, contact_pairs=())
    return replace(sample.log, joints=(), joint_position=None)


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ({"_func": "inside", "object": "red", "container": "box"}, "`box` has no volume `auto`; it has none"),
        (
            {"_func": "on", "object": "red", "support": "blue", "surface": "lid"},
            "`blue` has no surface `lid`; it has top",
        ),
        ({"_func": "upright", "object": "mug"}, "there is no object `mug`"),
        ({"_func": "joint_at", "joint": "oven/door", "at_least": 1.0}, "there is no joint `oven/door`"),
        ({"_func": "home", "robot": "other"}, "there is no home position of other"),
        ({"_func": "matches_attribute", "object": "box", "attribute": "colour", "equals": "red"}, "it has none"),
    ],
)
def test_what_is_missing_is_named(written: dict[str, object], word: str) -> None:
    predicate = predicate_from(written)
    with pytest.raises(StateMissing) as missing:
        predicate.values(Frames(logged(), SCENE, 0, 5), predicate.start())
    assert word in str(missing.value)


ANY, A = {"_func": "upright", "object": "$member"}, {"_func": "upright", "object": "a"}


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ({"_func": "insde", "object": "red", "container": "basket"}, "no predicate `insde`"),
        ({"object": "red", "container": "basket"}, "needs `_func`"),
        ({"_func": "inside", "object": "red", "container": "basket", "depth": 1}, "depth"),
        ({"_func": "oriented", "object": "red"}, "`direction` or `toward`"),
        ({"_func": "joint_at", "joint": "a/b"}, "`at_least`, `at_most` or both"),
        ({"_func": "joint_at", "joint": "a/b", "at_least": 2, "at_most": 1}, "is above"),
        ({"_func": "pressed", "joint": "a/b", "press_at": 1, "release_at": 1}, "must differ"),
        ({"_func": "counted", "members": ["a"], "where": ANY}, "give `exactly`"),
        ({"_func": "counted", "members": ["a"], "where": A, "exactly": 1}, "must speak of"),
        ({"_func": "near", "object": "red", "destination": "blue", "distance_m": float("nan")}, "finite"),
        ({"_func": "dwell", "of": A, "for_s": 0}, "greater than 0"),
    ],
)
def test_parameters_that_mean_nothing_are_refused(written: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        predicate_from(written)


def test_the_listing_of_the_paper_is_read() -> None:
    listing = {
        "_func": "object_near_destination",
        "object_cfg": "@pickable",
        "destination_cfg": "@container",
    }
    assert list(predicate_from(listing).objects()) == ["@pickable", "@container"]
