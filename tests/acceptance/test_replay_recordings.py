"""Objects put into recordings of real arms: recorded in PyBullet here, and by people (shared data). Judged by the other
code, which replays every interval at 16 times with proved distances."""

from pathlib import Path

import pytest

from benchmarks.replay.meshes import farthest_outside, first_rows, recorded_meshes
from replay.augmentation import prepare, variants
from replay.envelope.envelope import Settings, swept_envelope
from replay.insertion.candidates import InsertionCandidate, VariantChoices
from replay.recording.episode import Episode
from replay.recording.formats.read import read_episode
from replay.verification.inserted_bodies import inserted_body
from replay.verification.verify import near_pairs
from tests.support.bullet_recordings import DATA, record
from tests.support.plan.library import box_body

CLEARANCE_M = 0.01


def least_distances(episode: Episode, supports: tuple[str, ...], count: int) -> list[tuple[int, float]]:
    """For each variant the number of objects put in, and how near anything ever comes to one of them."""
    crate, plank = box_body("crate", 0.06, 0.05, 0.1), box_body("plank", 0.12, 0.04, 0.03)
    choices = VariantChoices([InsertionCandidate(body, body.stances[0]) for body in (crate, plank)] * 8)
    made = list(
        variants(prepare(episode, Settings(clearance_m=CLEARANCE_M), supports), lambda *_: choices, range(count), 3, 0)
    )
    bodies = [[inserted_body(one, None) for one in variant.inserted] for variant in made]
    near = near_pairs(episode, bodies, CLEARANCE_M)
    return [(len(put), pairs[0].distance_m) for put, pairs in zip(bodies, near, strict=True) if put]


@pytest.mark.parametrize("kind", ["sweep", "two_arms", "drawer"])
def test_arms_drawers_and_sweeps_of_the_table_are_kept_clear_of(kind: str, tmp_path: Path) -> None:
    """With irregular and repeated stamps."""
    found = least_distances(read_episode(record(tmp_path, kind), DATA), (), 3)
    assert [count for count, _ in found] == [3, 3, 3]
    assert min(distance for _, distance in found) >= CLEARANCE_M


@pytest.mark.shared
@pytest.mark.parametrize("name", ["panda_lift", "panda_stack"])
def test_recordings_of_people_are_kept_clear_of(name: str, shared_assets: Path) -> None:
    found = least_distances(read_episode(shared_assets.parent / "episodes" / name), (), 3)
    assert [count for count, _ in found] == [3, 3, 3]
    assert min(distance for _, distance in found) >= CLEARANCE_M


@pytest.mark.shared
@pytest.mark.parametrize("name", ["panda_lift", "panda_pick_place"])
def test_no_corner_of_a_recorded_mesh_is_ever_outside_the_envelope(name: str, shared_assets: Path) -> None:
    """Without clearance, at 16 times in each interval; `benchmarks.replay.meshes` asks the same of whole recordings."""
    folder = shared_assets.parent / "episodes" / name
    episode = first_rows(read_episode(folder), 25)
    envelope = swept_envelope(episode, Settings(clearance_m=0.0))
    asked, worst_m = farthest_outside(episode, envelope, recorded_meshes(folder), vertices=25)
    assert asked > 150_000
    assert -1e-3 < worst_m <= 0.0
