"""The smallest description for every `robot/` code: `SAMPLES[code]` are its files, the one to read first.

Codes that no file can trigger are in `NOT_FROM_A_DESCRIPTION`, with the test that triggers them.
"""

from __future__ import annotations

from pathlib import Path

Files = dict[str, str]


def urdf(*parts: str) -> Files:
    return {"model.urdf": f'<robot name="r">\n{"".join(parts)}</robot>\n'}


def mjcf(body: str = "", before: str = "", **more: str) -> Files:
    return {"model.xml": f"<mujoco>\n{before}<worldbody>\n{body}</worldbody>\n</mujoco>\n", **more}


def link(name: str, inside: str = "") -> str:
    return f'<link name="{name}">{inside}</link>\n'


def joint(name: str, parent: str, child: str, kind: str = "continuous", inside: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>\n'


def shape(geometry: str) -> str:
    return f"<collision><geometry>{geometry}</geometry></collision>"


def inertial(mass: float, ixx: float = 1.0) -> str:
    return f'<inertial><mass value="{mass}"/><inertia ixx="{ixx}" iyy="1" izz="1"/></inertial>'


AB = link("a") + link("b")

SAMPLES: dict[str, Files] = {
    "robot/unreadable": {"model.urdf": '<robot name="r">\n<link name="a">\n</robot>\n'},
    "robot/xml-declarations": {
        "model.urdf": '<!DOCTYPE r [<!ENTITY e "a">]>\n<robot name="r"><link name="&e;"/></robot>\n'
    },
    "robot/unknown-root": {"model.urdf": '<sdf version="1.6"/>\n'},
    "robot/xacro": urdf(link("${prefix}a")),
    "robot/path-escape": mjcf(before='<include file="../../other.xml"/>\n'),
    "robot/missing-file": mjcf(before='<include file="other.xml"/>\n'),
    "robot/repeated-include": mjcf(before='<include file="model.xml"/>\n'),
    "robot/missing-mesh": urdf(link("a", shape('<mesh filename="hand.obj"/>'))),
    "robot/missing-name": urdf("<link/>\n"),
    "robot/duplicate-name": urdf(link("a"), link("a")),
    "robot/no-links": urdf(),
    "robot/missing-link": urdf(link("a"), joint("j", "a", "b")),
    "robot/two-parents": urdf(AB, link("c"), joint("i", "a", "c"), joint("j", "b", "c")),
    "robot/link-cycle": urdf(AB, joint("i", "a", "b"), joint("j", "b", "a")),
    "robot/several-roots": urdf(AB),
    "robot/invalid-number": urdf(AB, joint("j", "a", "b", inside='<origin xyz="0 nan 0"/>')),
    "robot/zero-axis": urdf(AB, joint("j", "a", "b", inside='<axis xyz="0 0 0"/>')),
    "robot/axis-not-unit": urdf(AB, joint("j", "a", "b", inside='<axis xyz="0 0 2"/>')),
    "robot/invalid-orientation": mjcf('<body euler="1 0 0" quat="1 0 0 0"/>\n'),
    "robot/invalid-value": urdf(AB, joint("j", "a", "b", "screw")),
    "robot/unknown-class": mjcf('<geom class="wood" size="1"/>\n'),
    "robot/unknown-reference": mjcf('<geom type="mesh" mesh="hand"/>\n'),
    "robot/mimic-cycle": urdf(AB, joint("j", "a", "b", inside='<mimic joint="j"/>')),
    "robot/invalid-size": urdf(link("a", shape('<box size="1 0 1"/>'))),
    "robot/unsupported-shape": urdf(link("a", shape('<cone radius="1" length="1"/>'))),
    "robot/global-coordinates": mjcf(before='<compiler coordinate="global"/>\n'),
    "robot/invalid-mass": urdf(link("a", inertial(-1.0))),
    "robot/invalid-inertia": urdf(link("a", inertial(1.0, ixx=3.0))),
    "robot/missing-attribute": mjcf('<body><inertial mass="1" diaginertia="1 1 1"/></body>\n'),
    "robot/missing-inertial": urdf(link("a", shape('<sphere radius="1"/>'))),
    "robot/missing-limit": urdf(AB, joint("j", "a", "b", "revolute")),
    "robot/reversed-limits": urdf(AB, joint("j", "a", "b", "revolute", '<limit lower="1" upper="-1"/>')),
    "robot/unread-element": urdf(link("a"), "<gazebo/>\n"),
}
# Found when the moving structure is read, or in another kind of file.
NOT_FROM_A_DESCRIPTION: dict[str, str] = {
    "robot/not-expressible": "tests/formats/urdf/test_write.py",
    "robot/empty-link": "tests/formats/test_mechanism.py",
    "robot/base-joint": "tests/formats/test_mechanism.py",
    "robot/too-many-links": "tests/formats/test_mechanism.py",
    "robot/sdf": "tests/assetkit/sources/test_screening.py",
    "robot/closing-joint": "tests/usdio/read/test_mechanism.py",
}


def write(files: Files, folder: Path) -> Path:
    """Write the files; the path of the first."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder / next(iter(files))
