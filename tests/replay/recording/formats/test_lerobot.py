"""What LeRobot's own library writes is read, and it opens what comes out: v2.1 and v3.0, each by its last version."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from replay.recording.formats.read import read_episodes
from replay.recording.formats.write import write_variant
from replay.verification.check_output import check_output
from tests.replay.recording.description.test_from_description import described, empty_variant
from tests.support.lerobot_library import FPS, VERSIONS, Library
from tests.support.replay_samples import columns

ROWS = (12, 11)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    asked = Library(tmp_path_factory.mktemp("home"))
    yield asked
    asked.close()


def states(n: int) -> np.ndarray:
    """Joints and cube as one vector, as the library wants them (32 bits)."""
    rows = columns(n)
    cube = [rows[f"obj.cube.{c}"] for c in ("px", "py", "pz", "qw", "qx", "qy", "qz")]
    return np.stack([rows["q.turn"], rows["q.reach"], *cube], axis=1).astype(np.float32)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_library_and_mana_read_each_other(tmp_path: Path, library: Library, version: str):
    given = {f"state{k}": states(n) for k, n in enumerate(ROWS)}
    np.savez(
        tmp_path / "given.npz",
        **given,
        **{f"source_timestamp{k}": columns(n)["t"] for k, n in enumerate(ROWS)},
        allow_pickle=True,
    )
    data = tmp_path / "set"
    library.ask(version, data)
    names = ["q.turn", "q.reach", *(f"obj.cube.{c}" for c in ("px", "py", "pz", "qw", "qx", "qy", "qz"))]
    described(data, columns={name: f"observation.state[{k}]" for k, name in enumerate(names)})
    first, second = read_episodes(data)
    for episode, n in zip((first, second), ROWS, strict=True):
        np.testing.assert_array_equal(episode.t_s, columns(n)["t"])
        np.testing.assert_array_equal(episode.robots[0].q, states(n)[:, :2])

    done = write_variant(second, empty_variant(data), tmp_path / "out")
    assert check_output(tmp_path / "out", None, None)[0].sound
    library.ask(version, tmp_path / "out" / done.recording, episode=1)
    found = np.load(tmp_path / "out" / "found.npz")
    np.testing.assert_array_equal(found["state"], states(ROWS[1]))
    if version != "v2.1":
        np.testing.assert_array_equal(found["state_after"], states(ROWS[1])[1:])  # A frame later, found by time.
    np.testing.assert_array_equal(found["source_timestamp"], columns(ROWS[1])["t"])
    np.testing.assert_allclose(found["timestamp"], np.arange(ROWS[1]) / FPS, atol=float(found["tolerance_s"]))
