"""LeRobot's own library writes and opens data sets, by the interpreter that has it; `Library` asks it.

`make peers` makes that interpreter (`tools/torch-environment.sh`). As a script it answers requests line by line: it
imports what takes seconds once, and has the library of the asked version in a fork.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tests.support.peers import ENVIRONMENTS, peer_python

VERSIONS = ("v2.1", "v3.0")
FPS = 20
NAME = "tests/recorded"
FOLDER = ENVIRONMENTS["torch"]


class Library:
    """The asking side."""

    def __init__(self, home: Path) -> None:
        apart = {"HF_HUB_OFFLINE": "1", "HF_HOME": str(home), "SVT_LOG": "1", "PYTHONPATH": str(FOLDER.parent)}
        pipe = subprocess.PIPE
        command, env = [str(peer_python("torch")), "-m", __name__], os.environ | apart
        self._child = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True, env=env)

    def ask(self, version: str, folder: Path, episode: int | None = None) -> str:
        """Writes the data set `given.npz` beside a folder, or opens an episode of it into `found.npz`; what it said."""
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        self._child.stdin.write(json.dumps([version, str(folder), episode]) + "\n")
        self._child.stdin.flush()
        output = []
        while (line := self._child.stdout.readline()) not in ("", "done 0\n", "done 1\n"):
            output.append(line)
        assert line == "done 0\n", "".join(output)
        return "".join(output)

    def close(self) -> None:
        """Ends it."""
        assert self._child.stdin is not None
        self._child.stdin.close()
        self._child.wait(timeout=60)


def _answer(version: str, folder: str, episode: int | None) -> None:
    sys.path.insert(0, str(FOLDER / f"lerobot-{version}"))
    from lerobot.datasets.lerobot_dataset import CODEBASE_VERSION, LeRobotDataset

    assert version == CODEBASE_VERSION
    beside = Path(folder).parent
    if episode is None:
        return _write(LeRobotDataset, Path(folder), dict(np.load(beside / "given.npz")))
    # Rows asked for by time: the library judges the stamps. v2.1 does so anyway, and finds none of a later episode.
    pairs = None if version == "v2.1" else {"observation.state": [0.0, 1.0 / FPS]}
    data = LeRobotDataset(NAME, root=folder, episodes=[episode], delta_timestamps=pairs)
    states = np.stack([np.atleast_2d(data[k]["observation.state"].numpy()) for k in range(len(data))])
    columns = {"state": states[:, 0], "state_after": states[:-1, -1]}
    stored = data.hf_dataset.with_format("arrow")[:]  # Else 64 bits are made 32.
    columns |= {name: stored[name].to_numpy() for name in ("timestamp", "source_timestamp")}
    return np.savez(beside / "found.npz", **columns, tolerance_s=data.tolerance_s, allow_pickle=True)


def _write(kind: Any, folder: Path, given: dict[str, np.ndarray]) -> None:
    """Episodes 0, 1, ...: `state<k>` (n, j), `source_timestamp<k>` (n,), and a film of nothing."""
    joints, picture = given["state0"].shape[1], np.full((64, 96, 3), 90, dtype=np.uint8)
    features = {
        "observation.state": {"dtype": "float32", "shape": (joints,), "names": None},
        "source_timestamp": {"dtype": "float64", "shape": (1,), "names": None},
        "observation.images.front": {"dtype": "video", "shape": picture.shape, "names": ["height", "width", "channel"]},
    }
    data = kind.create(NAME, fps=FPS, features=features, root=folder)
    for k in range(sum(name.startswith("state") for name in given)):
        for state, stamp in zip(given[f"state{k}"], given[f"source_timestamp{k}"], strict=True):
            row = {"observation.state": state, "source_timestamp": np.array([stamp])}
            row["observation.images.front"] = picture
            if data.meta.info["codebase_version"] == "v2.1":
                data.add_frame(row, task="push")
            else:
                data.add_frame(row | {"task": "push"})
        data.save_episode()
    if hasattr(data, "finalize"):
        data.finalize()


if __name__ == "__main__":
    import datasets  # noqa: F401
    import torchvision  # noqa: F401

    for request in sys.stdin:
        child = multiprocessing.get_context("fork").Process(target=_answer, args=json.loads(request))
        child.start()
        child.join()
        print(f"done {int(child.exitcode != 0)}", flush=True)
