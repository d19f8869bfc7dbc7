"""A generative model runs as a program: what it was given, what it may write, and what becomes of a bad one."""

from __future__ import annotations

import json
import sys
import textwrap
from pathlib import Path

import pytest

from assetkit.generate.synthesize import SYNTHESIS_FILE, SynthesisRequest, synthesize
from jobs.cache import file_sha256
from jobs.cell import Limits
from schemas.diagnostics import InvalidInput
from tests.support.bad_inputs.assets import CUBE, obj_text

LIMITS = Limits(seconds=30.0, memory_mb=4096)
GOOD = """
    import json, sys
    from pathlib import Path
    request, answer = Path(sys.argv[1]), Path(sys.argv[2])
    asked = json.loads(request.read_text())
    assert asked["prompt"] == "a red cube" and asked["seed"] == 7
    assert request.with_name(asked["image"]).read_bytes() == b"picture"
    (answer / "colours.mtl").write_text("newmtl red\\nKd 1 0 0\\n")
    (answer / "Mesh 01.OBJ").write_text("mtllib colours.mtl\\n" + Path(TEXT).read_text())
"""


def program(folder: Path, source: str) -> list[str]:
    cube = folder / "cube.txt"
    cube.write_text(obj_text(CUBE))
    script = folder / "model.py"
    script.write_text(f"TEXT = {str(cube)!r}\n{textwrap.dedent(source)}")
    return [sys.executable, str(script)]


def test_a_model_is_given_the_request_and_its_mesh_is_kept_with_provenance(tmp_path: Path) -> None:
    image = tmp_path / "seen.PNG"
    image.write_bytes(b"picture")
    request = SynthesisRequest("a red cube", image, 7)
    target = synthesize(program(tmp_path, GOOD), "digest", request, tmp_path / "out", "red_cube", LIMITS)
    assert target == tmp_path / "out/red_cube.obj"
    assert (tmp_path / "out/colours.mtl").is_file()
    stated = json.loads((tmp_path / "out" / SYNTHESIS_FILE).read_text())
    assert stated["files"] == {name: file_sha256(tmp_path / "out" / name) for name in ("colours.mtl", "red_cube.obj")}
    assert (stated["program"], stated["program_sha256"], stated["seed"]) == ("model.py", "digest", 7)
    assert stated["image_sha256"] == file_sha256(image)
    assert str(tmp_path) not in json.dumps(stated)


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("raise SystemExit('no weights')", "no weights"),
        ("pass", "0 models instead of one"),
        ("import sys, pathlib as p\nfor n in 'ab': p.Path(sys.argv[2], n + '.obj').write_text('v 0 0 0')", "2 models"),
        ("import sys, os\nos.symlink('/etc/hostname', sys.argv[2] + '/a.obj')", "a link or a special file"),
        (
            "import sys, pathlib as p\nd = p.Path(sys.argv[2], 'x'); d.mkdir(); (d / 'a.obj').write_text('')",
            "below",
        ),
        ("import sys, pathlib as p\nfor n in range(300): p.Path(sys.argv[2], f'{n}.txt').write_text('')", "256 files"),
        ("import time; time.sleep(60)", "timeout"),
    ],
)
def test_a_program_that_gives_no_one_model_is_refused_and_leaves_nothing(tmp_path: Path, source: str, why: str) -> None:
    limits = Limits(seconds=2.0, memory_mb=4096)
    with pytest.raises(InvalidInput) as refused:
        synthesize(program(tmp_path, source), "", SynthesisRequest("x"), tmp_path / "out", "x", limits)
    assert refused.value.diagnostic.code == "asset/synthesis-failed"
    assert why in refused.value.diagnostic.headline
    assert not (tmp_path / "out").exists()
