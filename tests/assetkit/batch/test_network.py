"""The cell of an item has no network, unless the user named a model that may need it."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

from assetkit.batch import worker
from assetkit.options import Endpoint, Options
from jobs.cache import write_atomically
from sim.fake import FakeSimulator
from tests.support.bad_inputs.assets import CUBE, obj_text
from tests.support.namespaces import network_may_be_left

PORT_FILE, ANSWER = "port", "answer"


class CallingEngine(FakeSimulator):
    """Tries to reach a server of this machine when the cell starts it; leaves a note beside the request."""

    def __enter__(self) -> CallingEngine:
        place = Path(sys.argv[1]).parent
        try:
            socket.create_connection(("127.0.0.1", int((place / PORT_FILE).read_text())), 2).close()
            note = "reached"
        except OSError:
            note = "cut off"
        write_atomically(place / ANSWER, note.encode())
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass


def answer(place: Path, options: Options) -> str:
    """What the engine of a cell noted that works on a cube."""
    (place / "cube.obj").write_text(obj_text(CUBE))
    request = {
        "given": "cube.obj",
        "path": str(place / "cube.obj"),
        "root": str(place),
        "format": "obj",
        "asset_id": "cube",
        "options": options.model_dump(mode="json"),
        "engine": "tests.assetkit.batch.test_network:CallingEngine",
        "out": str(place / "out"),
        "work_dir": str(place / "work"),
        "note": str(place / "note.json"),
        "fresh": False,
    }
    file = place / "request.json"
    file.write_text(json.dumps(request))
    with socket.create_server(("127.0.0.1", 0)) as server:
        (place / PORT_FILE).write_text(str(server.getsockname()[1]))
        with subprocess.Popen([sys.executable, "-m", worker.__name__, str(file)], stderr=subprocess.DEVNULL) as cell:
            while cell.poll() is None and not (place / ANSWER).exists():
                time.sleep(0.05)
            cell.kill()  # The engine has called; what becomes of the cube is no matter.
    return (place / ANSWER).read_text()


def test_a_cell_is_cut_off_where_the_system_allows_it(tmp_path: Path) -> None:
    assert answer(tmp_path, Options()) == ("cut off" if network_may_be_left() else "reached")


def test_a_cell_that_calls_a_model_is_not(tmp_path: Path) -> None:
    model = Endpoint(url="http://127.0.0.1:9/v1", model="none")
    assert answer(tmp_path, Options(endpoint=model)) == "reached"
