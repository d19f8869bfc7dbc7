"""The smallest scene program for every `scene/` code. All start from one sound program with one thing changed.

`SAMPLES` are wrong as texts, `BOUND` once assets are looked at; of `VERDICTS` no scene is found.
A sample is the text of `program.yaml`, or several files by name.
"""

from __future__ import annotations

from pathlib import Path

Text = str | dict[str, str]

HEAD = "background: {asset: {type: box, size_m: [1.2, 0.8, 0.05]}}\n"
ANCHORS = "anchors: {tabletop: {object: background, surface: auto}}\n"
BOX = "{type: box, size_m: [0.1, 0.1, 0.1]}"
OBJECTS = f"objects: [{{id: a, asset: {BOX}}}, {{id: b, asset: {BOX}}}, {{id: c, asset: {BOX}}}]\n"
ON = "{type: surface, surface: tabletop}"
NODES = "".join(f"    {name}: {{object: {name}, placement: {ON}}}\n" for name in "abc")
LAYOUT = f"layout:\n  nodes:\n{NODES}"
SOUND = HEAD + ANCHORS + OBJECTS + LAYOUT
GROUPED = HEAD + ANCHORS + OBJECTS + "layout:\n  nodes: {a: {object: a}, b: {object: b}, c: {object: c}}\n  groups:\n"
REGION = "    row: {type: region, members: [a, b, c], surface: tabletop}\n"
SLOTS = "    rack: {type: slot, members: [a, b, c], surface: tabletop, slots: [%s], assign: {%s}}\n"
CUBES = tuple(f"cube_{i}" for i in range(17))
THREE = "{id: l, x: -0.2, y: 0}, {id: m, x: 0, y: 0}, {id: r, x: 0.2, y: 0}"
ON_TRAY = (
    SOUND.replace("tabletop: {object: background", "inside: {object: a, surface: auto}, tabletop: {object: background")
    .replace(f"b: {{object: b, placement: {ON}", "b: {object: b, placement: {type: surface, surface: inside}")
    .replace("size_m: [0.1, 0.1, 0.1]}}, {id: b", "size_m: [0.3, 0.3, 0.02]}}, {id: b")
)

ON_LID = SOUND.replace("anchors: {", "anchors: {lid: {object: a, surface: lid/top}, ").replace(
    f"b: {{object: b, placement: {ON}", "b: {object: b, placement: {type: surface, surface: lid}"
)


def pool(*assets: str, of: str = "a", text: str = SOUND) -> str:
    """The program with a pool for an object."""
    candidates = f"[{{id: p, assets: [{', '.join(assets)}]}}]"
    return text.replace(f"id: {of}, asset: {BOX}", f"id: {of}, asset: {{type: pool, candidates: {candidates}}}")


def jointed(asset: str, joints: str, text: str = SOUND) -> str:
    """The program with an articulated asset as `a`, in a joint state."""
    text = text.replace(f"id: a, asset: {BOX}", f"id: a, asset: {{type: fixed, id: {asset}}}")
    return text.replace("a: {object: a, ", f"a: {{object: a, joints: {joints}, ")


def deep(levels: int) -> str:
    return "definition: " + "[" * levels + "]" * levels + "\n"


def placed(**at: str) -> str:
    """The sound program with other ranges for some nodes."""
    text = SOUND
    for name, ranges in at.items():
        text = text.replace(
            f"{name}: {{object: {name}, placement: {ON}",
            f"{name}: {{object: {name}, placement: {ON[:-1]}, ranges: {ranges}}}",
        )
    return text


SAMPLES: dict[str, Text] = {
    "scene/missing-file": "include: nothing.yaml\n",
    "scene/path-escape": "include: ../program.yaml\n",
    "scene/file-too-large": deep(100),
    "scene/yaml-syntax": SOUND.replace("]}}\n", "]}\n", 1),
    "scene/include-cycle": {"program.yaml": "include: b.yaml\n", "b.yaml": "include: program.yaml\n"},
    "scene/bad-overlay": {"program.yaml": "include: b.yaml\nobjects: {d: {$delete: true}}\n", "b.yaml": SOUND},
    "scene/unknown-key": SOUND.replace("layout:", "layot:"),
    "scene/missing-key": SOUND.replace("object: a, ", ""),
    "scene/invalid-value": SOUND.replace("0.05]", "-0.05]"),
    "scene/given-twice": placed(a="{yaw: [0, 1], yaw_deg: [0, 90]}"),
    "scene/range-reversed": placed(a="{x: [0.2, 0.1]}"),
    "scene/degrees-suspected": placed(a="{yaw: [-90, 90]}"),
    "scene/size-implausible": SOUND.replace("[0.1, 0.1, 0.1]", "[21, 15, 3]", 1),
    "scene/duplicate-id": SOUND.replace("]\nlayout", f", {{id: a, asset: {BOX}}}]\nlayout"),
    "scene/unknown-name": SOUND + "relations: [{left_of: [a, d]}]\n",
    "scene/ambiguous-name": SOUND.replace("anchors: {", "anchors: {lid: {object: a, surface: auto}, ").replace(
        "    a: {object: a", f"    d: {{object: a, placement: {ON}}}\n    e: {{object: a"
    ),
    "scene/missing-anchor": SOUND.replace("surface: tabletop", "surface: shelf", 1),
    "scene/two-owners": SOUND + "  groups:\n" + REGION.replace("a, b, c", "a"),
    "scene/no-owner": SOUND.replace(f"c, placement: {ON}", "c"),
    "scene/owner-cycle": ON_TRAY.replace("anchors: {", "anchors: {lid: {object: b, surface: auto}, ").replace(
        f"a: {{object: a, placement: {ON}", "a: {object: a, placement: {type: surface, surface: lid}"
    ),
    "scene/owner-not-upright": ON_TRAY.replace(
        f"a: {{object: a, placement: {ON[:-1]}", f"a: {{object: a, placement: {ON[:-1]}, orientation: stable"
    ),
    "scene/unplaced-object": SOUND.replace("object: c", "object: b"),
    "scene/slot-assignment": GROUPED + SLOTS % (THREE, "a: l, b: l"),
    "scene/split-overlap": SOUND + "split: {train: [mug_a, mug_b], eval: [mug_b]}\n",
    "scene/relation-words": SOUND + "relations: [{left_of: [a, b], behind: [a, b]}]\n",
    "scene/relation-self": SOUND + "relations: [{left_of: [a, a]}]\n",
    "scene/option-without-effect": SOUND + "relations: [{left_of: [a, b], distance: 0.1}]\n",
    "scene/distractor-overlap": SOUND
    + "distractors: [{id: d, pool: [cube], count: [0, 2], surface: tabletop}]\nsplit: {eval: [cube]}\n",
    "scene/distractor-named": SOUND
    + "distractors: [{id: d, pool: [cube], count: [0, 2], surface: tabletop}]\nrelations: [{left_of: [a, d]}]\n",
    "scene/robot-reach": SOUND + "reach: {base: [0, 0, 0], radius: 0.8, robot: panda}\n",
    "scene/joint-state-range": jointed("drawer_unit", "{drawer_1: [0.1, 0.2]}"),
    "scene/grid-size": GROUPED
    + "    rack: {type: grid, members: [a, b, c], surface: tabletop, rows: 2, columns: 2, pitch: [0.2, 0.2]}\n",
    "scene/too-many": GROUPED + "    many: {type: scatter, members: [a, b, c], surface: tabletop, count: 1000000000}\n",
}

BOUND: dict[str, Text] = {
    "scene/frame-needed": ON_TRAY + "relations: [{left_of: [b, c]}]\n",
    "scene/unknown-asset": pool("not_there"),
    "scene/unusable-asset": pool("torn"),
    "scene/role-mismatch": pool("cube").replace("id: a,", "id: a, role: mechanism,"),
    "scene/no-stable-pose": pool("cube").replace(
        f"a: {{object: a, placement: {ON[:-1]}", f"a: {{object: a, placement: {ON[:-1]}, orientation: stable"
    ),
    "scene/asset-in-review": pool("doubtful"),
    "scene/beyond-exercised": pool("tried")
    + "variants: {materials: [{id: oil, objects: [a], dynamic_friction: 0.1}]}\n",
    "scene/topples": pool("rod"),
    "scene/round-floor": SOUND.replace(f"id: a, asset: {BOX}", "id: a, asset: {type: fixed, id: bowl}")
    .replace("anchors: {", "anchors: {inside: {object: a, volume: auto}, ")
    .replace(f"b: {{object: b, placement: {ON}", "b: {object: b, placement: {type: volume, volume: inside}"),
    "scene/unknown-joint": jointed("drawer_unit", "{drawer_3: 0.1}"),
    "scene/joint-range": jointed("drawer_unit", "{drawer_1: 0.4}"),
    "scene/joint-follows": jointed("chest", "{latch: 0.01}"),
    "scene/joint-loop": jointed("four_bar", "{left: 0.5}"),
    "scene/scaled-joints": jointed("drawer_unit", "{drawer_1: 0.1}").replace(
        "drawer_unit}", "drawer_unit}, scale: 0.5"
    ),
    "scene/leaning-anchor": jointed("chest", "{lid: 1.0}", ON_LID),
    "scene/no-swept-volume": jointed("chest", "{}") + "keep_clear: [{object: a, joint: lid}]\n",
    "scene/unknown-part": SOUND + "relations: [{facing: [a.handle, b]}]\n",
    "scene/part-without-direction": pool("mug") + "relations: [{facing: [a.lid, b]}]\n",
    "scene/stack-unsteady": GROUPED
    + "    pile: {type: stack, members: [a, b, c], surface: tabletop, alignment: 0.03}\n",
    "scene/union-footprints": pool(*CUBES, of="b", text=pool(*CUBES)),
}

STRIP = "{x: [0, 0.05], y: [-0.1, 0.1]}"

VERDICTS: dict[str, Text] = {
    "scene/relation-cycle": SOUND + "relations: [{left_of: [a, b]}, {left_of: [b, c]}, {left_of: [c, a]}]\n",
    "scene/too-wide": placed(a="{x: [0, 0.1]}", b="{x: [0.4, 0.5]}") + "relations: [{near: [a, b], distance: 0.1}]\n",
    "scene/area-bound": SOUND.replace("[1.2, 0.8, 0.05]", "[0.16, 0.16, 0.05]"),
    "scene/empty-region": placed(a="{x: [0.58, 0.59]}"),
    "scene/empty-domain": GROUPED + SLOTS % (THREE.replace("0.2", "2.0").replace("x: 0,", "x: 1.0,"), ""),
    # b is to turn its front to a, which is behind it, and may not turn.
    "scene/infeasible": placed(a="{x: [-0.3, -0.2], yaw: [0, 0]}", b="{x: [0.2, 0.3], yaw: [0, 0]}")
    + "relations: [{facing: [b, a]}]\n",
    "scene/no-view": SOUND
    + "cameras: [{id: c, position: {x: [2, 2], y: [0, 0], z: [1, 1]}, look_at: [4, 0, 1], fov_deg: [50, 50],\n"
    + "  size: [64, 48], visible: [{object: a, pixels: 5}]}]\n",
    # Three of 10 cm in a row of 30 cm with 1 cm between them: a little too tight, which no argument shows so far.
    "scene/budget-exhausted": placed(a=STRIP, b=STRIP, c=STRIP),
}


def write(sample: Text, folder: Path) -> Path:
    """The program file of a sample, written into `folder`."""
    files = {"program.yaml": sample} if isinstance(sample, str) else sample
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder / "program.yaml"
