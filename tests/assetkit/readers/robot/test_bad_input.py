"""Bad descriptions come back as codes, through intake and canonicalize: never an exception, never a silent loss.

The last ones are the smallest inputs of what `tests.suites.fuzz.run --format urdf --format mjcf` found.
"""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from assetkit.options import Options
from assetkit.readers.robot import read as read_robot_module
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from tests.suites.fuzz.readers import asset
from tests.support.bad_inputs.robot import Files, joint, link, mjcf, shape, urdf, write

PANEL = shape('<box size="0.4 0.02 0.5"/>')
TWO = link("a", PANEL) + link("b", PANEL)
AXIS, LIMIT = '<axis xyz="0 0 1"/>', '<limit lower="{}" upper="{}" effort="1" velocity="1"/>'
MANY = 10_000


def hinge(inside: str, child: str = "b") -> str:
    return joint("j", "a", child, "revolute", inside)


def slide(size: str) -> Files:
    return urdf(link("a", shape(size)), link("b", shape(size)), hinge(AXIS + LIMIT.format(0, 1)))


def examined(files: Files, folder: Path) -> tuple[object, object, bool, list[str]]:
    """Objects made, broken promises, whether no exception was raised, and codes of findings."""
    note = asset.read(folder, write(files, folder))
    return note.made, note.broken, not note.trace, note.codes


REFUSED = {
    "limits that are no numbers": (urdf(TWO, hinge(AXIS + LIMIT.format("nan", 1))), "robot/invalid-number"),
    "limits without end": (urdf(TWO, hinge(AXIS + LIMIT.format("-inf", "inf"))), "robot/invalid-number"),
    "an axis of zeros": (urdf(TWO, hinge('<axis xyz="0 0 0"/>' + LIMIT.format(0, 1))), "robot/zero-axis"),
    "an axis of almost zeros": (urdf(TWO, hinge('<axis xyz="0 0 1e-300"/>' + LIMIT.format(0, 1))), "robot/zero-axis"),
    "a joint to a missing link": (urdf(TWO, hinge(AXIS + LIMIT.format(0, 1), "c")), "robot/missing-link"),
    "a joint to its own parent": (urdf(TWO, hinge(AXIS + LIMIT.format(0, 1), "a")), "robot/link-cycle"),
    "a cycle": (urdf(TWO, joint("i", "a", "b"), joint("j", "b", "a")), "robot/link-cycle"),
    "a mesh above the root": (urdf(link("a", shape('<mesh filename="../../../x/y.obj"/>'))), "robot/path-escape"),
    "a mesh by an absolute path": (urdf(link("a", shape('<mesh filename="/x/y.obj"/>'))), "robot/path-escape"),
    "a mesh of an include above the root": (
        mjcf('<geom type="mesh" mesh="m"/>', before='<asset><mesh name="m" file="../../../x/y.obj"/></asset>'),
        "robot/path-escape",
    ),
    "MJCF: limits that are no numbers": (
        mjcf('<body><joint range="nan 1"/><geom size="1"/></body>'),
        "robot/invalid-number",
    ),
    "MJCF: an axis of zeros": (mjcf('<body><joint axis="0 0 0"/><geom size="1"/></body>'), "robot/zero-axis"),
    "MJCF: a mesh that names none": (mjcf('<body><geom type="mesh" mesh=""/></body>'), "robot/unknown-reference"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_by_its_code(name: str, tmp_path: Path) -> None:
    files, code = REFUSED[name]
    assert examined(files, tmp_path) == (0, [], True, [code])


REPAIRED = {
    "limits the wrong way round": (urdf(TWO, hinge(AXIS + LIMIT.format(1, -1))), "robot/reversed-limits"),
    "MJCF: limits the wrong way round": (
        mjcf('<geom size="1"/>\n<body><joint range="1 -1"/><geom size="1"/></body>'),
        "robot/reversed-limits",
    ),
    "an axis of another length": (
        urdf(TWO, hinge('<axis xyz="0 0 1000"/>' + LIMIT.format(0, 1))),
        "robot/axis-not-unit",
    ),
    "lengths in millimetres": (slide('<box size="400 20 500"/>'), "asset/contradictory-evidence"),
}


@pytest.mark.parametrize("name", REPAIRED)
def test_what_can_be_repaired_is_made_and_the_defect_is_named(name: str, tmp_path: Path) -> None:
    files, code = REPAIRED[name]
    made, broken, whole, codes = examined(files, tmp_path)
    assert (made, broken, whole) == (1, [], True)
    assert code in codes


CHAIN = "".join(
    [*(link(f"l{k}", PANEL) for k in range(MANY)), *(joint(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(MANY - 1))]
)
BODIES = "".join(f'<body name="b{k}"><joint/><geom size="0.1"/></body>' for k in range(MANY // 10))


@pytest.mark.parametrize(
    ("files", "code"),
    [(urdf(CHAIN), "robot/too-many-links"), (mjcf(f'<geom size="1"/>\n{BODIES}'), "robot/too-many-links")],
    ids=["urdf", "mjcf"],
)
def test_many_links_are_refused_in_time_linear_in_their_number(files: Files, code: str, tmp_path: Path) -> None:
    """10,000 take 5 s of a core in URDF, 1,000 half a second in MJCF; quadratic time would take minutes."""
    path = write(files, tmp_path)
    started = time.process_time()
    note = asset.read(tmp_path, path)
    assert note.codes == [code]
    assert time.process_time() - started < 30.0


@pytest.mark.parametrize(
    ("inside", "name", "axis", "limits"),
    [
        ('<axis xyz="0 0 1000"/>' + LIMIT.format(0, 1), "unit_axis", (0.0, 0.0, 1.0), (0.0, 1.0)),
        (AXIS + LIMIT.format(1, -1), "swap_limits", (0.0, 0.0, 1.0), (-1.0, 1.0)),
    ],
)
def test_a_repaired_joint_is_that_of_the_good_description_and_the_record_names_the_repair(
    inside: str, name: str, axis: tuple[float, ...], limits: tuple[float, float], tmp_path: Path
) -> None:
    path = write(urdf(TWO, hinge(inside)), tmp_path)
    (candidate,) = discover([path])
    taken = ReadSource().run(candidate, Options())
    mechanism = taken.objects[0].model.mechanism
    assert mechanism is not None
    assert mechanism.joints[0].axis == pytest.approx(axis)
    assert mechanism.joints[0].limits == limits
    assert name in [repair.name for repair in taken.repairs]


def test_shapes_of_too_many_triangles_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """10,000 capsules fill 5 GiB; the bound is lowered to what this file has, less one."""
    files = mjcf('<geom size="1"/><body><geom size="1"/></body>')
    model = ReadSource().run(discover([write(files, tmp_path)])[0], Options()).objects[0].model
    count = sum(len(mesh.triangles) for mesh in model.meshes)
    for bound, codes in ((count, []), (count - 1, ["asset/resource-limit"])):
        monkeypatch.setattr(read_robot_module, "MOST_TRIANGLES_READ", bound)
        note = asset.read(tmp_path, write(files, tmp_path))
        assert [code for code in note.codes if code == "asset/resource-limit"] == codes
