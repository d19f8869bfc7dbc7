"""The smallest recording for every `replay/` code: `SAMPLES[code](folder)` writes it and returns the path to read.

Codes that no recording can trigger are in `NOT_FROM_A_RECORDING`, with the test that triggers them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.support.replay_samples import MODEL, columns, staged

Writer = Callable[[Path], Path]


def text(name: str, content: str = "") -> Writer:
    def write(folder: Path) -> Path:
        (folder / name).write_text(content)
        return folder / name

    return write


def changed(name: str, row: int, value: float) -> Writer:
    def write(folder: Path) -> Path:
        rows = columns()
        rows[name][row] = value
        return staged(folder, rows)

    return write


def model(old: str, new: str) -> Writer:
    return lambda folder: staged(folder, model=MODEL.replace(old, new))


def without(name: str) -> Writer:
    return lambda folder: staged(folder, {k: v for k, v in columns().items() if k != name})


def damaged(folder: Path) -> Path:
    (staged(folder) / "episode.parquet").write_bytes(b"PAR1")
    return folder


def flat_mesh(folder: Path) -> Path:
    np.savez(staged(folder) / "meshes_body_frame.npz", **{"lower|geom4|v": np.eye(3)}, allow_pickle=True)
    return folder


def two_models(folder: Path) -> Path:
    (staged(folder) / "raw" / "other.xml").write_text(MODEL)
    return folder


SAMPLES: dict[str, Writer] = {
    "replay/unknown-format": text("log.txt"),
    "replay/missing-file": two_models,
    "replay/unreadable": damaged,
    "replay/path-escape": model("<worldbody>", '<include file="../../other.xml"/><worldbody>'),
    "replay/missing-mesh": lambda folder: staged(folder, meshes=False),
    "replay/bad-mesh": flat_mesh,
    "replay/missing-column": without("q.turn"),
    "replay/not-finite": changed("q.turn", 3, np.nan),
    "replay/time-decreases": changed("t", 3, 0.0),
    "replay/invalid-value": model('axis="1 0 0"', 'axis="1 0"'),
    "replay/unsupported-model": model('type="slide"', 'type="ball"'),
}
NOT_FROM_A_RECORDING: dict[str, str] = {
    "replay/state-size": "tests/replay/recording/formats/test_read.py",
    "replay/uncovered-link": "tests/replay/recording/formats/test_read.py",
    "replay/no-support": "tests/replay/envelope/test_envelope.py",
    "replay/no-candidates": "tests/cli/replay/test_augment.py",
    "replay/no-room": "tests/cli/replay/test_augment.py",
    "replay/out-taken": "tests/cli/replay/test_augment.py",
    "replay/missing-camera": "tests/cli/replay/test_augment.py",
    "replay/stopped": "tests/cli/replay/test_augment.py",
}
