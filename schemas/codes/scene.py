"""Diagnostic codes of scene programs and of the scene compiler; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo
from schemas.scene.relations import RELATION_WORDS

SCENE_CODES: dict[str, CodeInfo] = {
    # The text and its includes.
    "scene/missing-file": CodeInfo(
        "error",
        "A program or a file that it includes is absent",
        "Without the file the program would be another one than the one meant.",
        "correct the path: it is read relative to the file that includes it",
    ),
    "scene/path-escape": CodeInfo(
        "error",
        "An include leads out of the root folder",
        "A program is a folder that can be copied; a path outside it is unsafe and breaks on the next machine.",
        "copy the file into the folder of the program, or name a higher folder as root",
    ),
    "scene/file-too-large": CodeInfo(
        "error",
        "The text is larger, deeper or wider than the reader takes",
        "The bounds on bytes, depth and number of values (aliases and includes counted out) keep a damaged or hostile "
        "file from filling the memory.",
        "split the program into fragments; use a scatter group with `count` for many like things",
    ),
    "scene/yaml-syntax": CodeInfo(
        "error",
        "The file is not valid YAML",
        "A parser that guesses past a syntax error reads another program than the one meant.",
        "correct the line named; indent with spaces, close every bracket and write each key once",
    ),
    "scene/include-cycle": CodeInfo(
        "error",
        "A file includes itself, directly or through others",
        "There is no base to start from.",
        "move what the files share into a fragment that includes none of them",
    ),
    "scene/bad-overlay": CodeInfo(
        "error",
        "A rule of an overlay has nothing to work on",
        "`$append` needs a list, `$delete` something that the base has; else a misspelt name would change nothing.",
        "name a key or an id of the included file; `$append: [...]` and `$replace: [...]` stand where the list is",
    ),
    "scene/unknown-key": CodeInfo(
        "error",
        "A key has no meaning here",
        "A misspelt key would silently leave its default in force.",
        "take the nearest key where one is suggested, or remove it; `mana scene schema` prints the language",
    ),
    "scene/missing-key": CodeInfo(
        "error",
        "A value that is needed is not given",
        "The compiler does not invent what a scene holds.",
        "add the key named",
    ),
    "scene/invalid-value": CodeInfo(
        "error",
        "A value has the wrong type, size or sign",
        "The value cannot mean what its key says.",
        "correct the value; lengths are in metres, angles in radians, in degrees where the key ends in `_deg`",
    ),
    "scene/given-twice": CodeInfo(
        "error",
        "The same thing is said by two keys",
        "An angle in radians and in degrees, or an outline and ranges: either could be meant.",
        "keep one of the two keys",
    ),
    "scene/range-reversed": CodeInfo(
        "error",
        "A range ends before it begins",
        "No value lies in it.",
        "write the smaller number first; a range of headings across the half turn goes on past it, as in [170, 190]",
    ),
    "scene/degrees-suspected": CodeInfo(
        "error",
        "An angle in radians looks like one in degrees",
        "Angles are radians unless the key ends in `_deg`. More than a full turn either way is most likely meant in "
        "degrees; read as radians it leaves every heading free, or gives one that nobody meant. Within a full turn "
        "only whole numbers from 4 on are doubted (from 2 on for the tolerance of `facing`), as a warning.",
        "write degrees with the key that ends in `_deg`, or radians within a full turn either way",
    ),
    "scene/size-implausible": CodeInfo(
        "warning",
        "An inline size can hardly be in metres",
        "Sizes are metres. An object of more than 3 m is most likely written in centimetres or millimetres; so is a "
        "background (or an object with the role `support` or `fixture`) that is 10 m long and nowhere thinner than "
        "1 m. A thin floor or wall may have any size.",
        "write the size in metres; a warning about something that really is so large can be left as it is",
    ),
    # Names and ownership.
    "scene/duplicate-id": CodeInfo(
        "error",
        "Two things have the same id",
        "A reference could mean either.",
        "rename one of them",
    ),
    "scene/unknown-name": CodeInfo(
        "error",
        "A name stands for nothing in this program",
        "A relation, group or variant of something that does not exist would silently play no part.",
        "use the name suggested, or declare it",
    ),
    "scene/ambiguous-name": CodeInfo(
        "error",
        "A name stands for several placed things",
        "What stands on an object that is placed more than once could stand on either.",
        "name the node instead of its object",
    ),
    "scene/missing-anchor": CodeInfo(
        "error",
        "A place that the program names does not exist",
        "Things can only be put on a surface or into a volume that an anchor of the program, and the asset behind it, "
        "really offers. A fragment that leaves its anchors to others is no program of its own.",
        "add the name to `anchors`, include the fragment that defines it, or draw the polygon there",
    ),
    "scene/two-owners": CodeInfo(
        "error",
        "A node is placed twice",
        "Two owners of one pose would contradict one another.",
        "remove its `placement`, or take it out of all groups but one",
    ),
    "scene/no-owner": CodeInfo(
        "error",
        "A node has no placement and is in no group",
        "Nothing says where it may be.",
        "give it a `placement`, or make it a member of a group",
    ),
    "scene/owner-cycle": CodeInfo(
        "error",
        "Things stand on one another in a circle",
        "None of them stands on anything that stays.",
        "put one of them on the background",
    ),
    "scene/owner-not-upright": CodeInfo(
        "error",
        "Something stands on a thing that may be turned over",
        "Surfaces and volumes are known in the reference pose; on its side a tray holds nothing.",
        "leave the orientation of the supporting thing `upright`",
    ),
    "scene/unplaced-object": CodeInfo(
        "warning",
        "An object is declared and never placed",
        "It will not be in the scene; a forgotten node looks just like this.",
        "add a node for it under `layout.nodes`, or remove it",
    ),
    "scene/round-floor": CodeInfo(
        "warning",
        "The floor of a receptacle is level over a small part only",
        "Things are placed standing, on a level floor or on each other. What lies in a bowl leans on its wall; no such "
        "pose is tried, so that where none is found nothing is proved, and what stands off the middle may slide.",
        "write its poses (`discrete`), place it in a receptacle with a level floor, or read what settling says",
    ),
    "scene/slot-assignment": CodeInfo(
        "error",
        "Slots are assigned so that members cannot each have one",
        "Two members in one slot would overlap.",
        "give every member a slot of its own",
    ),
    "scene/split-overlap": CodeInfo(
        "error",
        "An asset is in the training and in the evaluation split",
        "What a policy has seen is no test of what it has not.",
        "remove it from one of the two lists",
    ),
    # Relations.
    "scene/relation-words": CodeInfo(
        "error",
        "A relation says nothing, or two things at once",
        "Each entry is one relation, so that a conflict can name it.",
        f"write one of {', '.join(row.word for row in RELATION_WORDS)} per entry",
    ),
    "scene/relation-self": CodeInfo(
        "error",
        "A relation has the same thing on both sides",
        "Nothing is left of itself.",
        "name two different nodes; a group stands for all its members",
    ),
    "scene/option-without-effect": CodeInfo(
        "error",
        "A key does not belong to what it is written beside",
        "A distance beside left_of would be ignored in silence; left_of takes `gap`.",
        "remove the key, or use the one that belongs here",
    ),
    "scene/frame-needed": CodeInfo(
        "error",
        "A direction is asked between things whose supports may be turned against one another",
        "Left on a tray that turns is not left on the table: the program must say whose axes count.",
        "add `frame:` with the name of an anchor or a node, or `world`",
    ),
    # Assets.
    "scene/unknown-asset": CodeInfo(
        "error",
        "An asset is not in the library",
        "Footprints come from real collision geometry, so each asset must be there.",
        "check the id (`mana assets list DIR`), ingest the asset, or name the library with `--assets DIR`",
    ),
    "scene/unusable-asset": CodeInfo(
        "error",
        "A package of the library cannot be used",
        "Its record or its USD file cannot be read, or it has no collision shape.",
        "look at it with `mana assets validate`; ingest the source again",
    ),
    "scene/role-mismatch": CodeInfo(
        "error",
        "A candidate cannot play the object's role",
        "Candidates may stand for one another; one that cannot hold things is no receptacle.",
        "drop the candidate, or correct the role of the asset or of the object",
    ),
    "scene/no-stable-pose": CodeInfo(
        "warning",
        "No stable pose of the asset is known",
        "`orientation: stable` asks for poses found by drop trials; the record holds none, so the reference pose is "
        "used.",
        "write `upright`, or the orientations that you want",
    ),
    "scene/asset-in-review": CodeInfo(
        "warning",
        "A package waits for review",
        "Its ingest ended with something that a person should look at, such as a collider that misses its tolerance. "
        "The scene is made with the package as it is, and can be no better.",
        "look at the findings of its record (`mana assets show`), or use another asset",
    ),
    "scene/beyond-exercised": CodeInfo(
        "warning",
        "A paired material gives an object friction or mass that acceptance did not exercise",
        "A package is accepted for the friction and mass at which its suites passed; beyond that a gripper may "
        "lose it, or it may tip over, and a sample would be valid only by its geometry.",
        "choose values within the range shown, leave the material out for this object, or see what fails with "
        "`mana assets accept`",
    ),
    "scene/topples": CodeInfo(
        "warning",
        "An asset does not rest in the pose in which it is placed",
        "In drop trials it came to rest in other poses only. Let go in a simulator, it will fall over.",
        "write `orientation: stable`, or one of the stable poses of its record",
    ),
    # Joints.
    "scene/unknown-joint": CodeInfo(
        "error",
        "An asset has no such joint that can be set",
        "A misspelt joint would silently stay at rest. Rigid assets have none; a ball joint has no single position.",
        "take one of the joints listed: those of the record of the asset (`mana assets show`)",
    ),
    "scene/joint-range": CodeInfo(
        "error",
        "A joint is placed beyond its limits",
        "No mechanism gets there, and a simulator would push it back at the first step. Joints that follow the one "
        "written must stay within their limits, too.",
        "write a position between the two bounds: metres for slides, radians for hinges, degrees with `_deg`",
    ),
    "scene/joint-follows": CodeInfo(
        "error",
        "The position of a joint follows from others",
        "A coupled joint stands where the joint that it follows puts it, and a joint that closes a loop where the "
        "others do.",
        "write the position of the joint that it follows",
    ),
    "scene/joint-loop": CodeInfo(
        "error",
        "A loop of links does not close in the state that is written",
        "The positions of the joints of a loop depend on one another; these pull its ends apart.",
        "write positions that go together, or leave the joints of the loop at rest",
    ),
    "scene/scaled-joints": CodeInfo(
        "error",
        "An asset with joints is scaled",
        "The limits, drives and masses of its links hold for its own size.",
        "use it at scale 1; ingest the source at another unit for another size",
    ),
    "scene/leaning-anchor": CodeInfo(
        "error",
        "A place leans in the joint state of its object",
        "The surfaces of a link turn with it. On a lid that stands open, and in a bin tipped out, nothing rests.",
        "take another place, or another position of the joint",
    ),
    "scene/no-swept-volume": CodeInfo(
        "error",
        "The space that a joint sweeps is not known",
        "`keep_clear` needs the swept volume of the record. It is that of the joint alone, with all others at rest: a "
        "link that another joint moved or tilted sweeps another space, and a joint of a loop moves others along.",
        "leave the joints that carry or are carried by this one at rest; ingest the asset again if its record is old",
    ),
    "scene/union-footprints": CodeInfo(
        "info",
        "Combinations of variants were not compiled one by one",
        "Those that reach these things are more than are solved singly. Pools of things that carry nothing were given "
        "the union of the footprints of all their candidates: a scene then holds for each. Where the union has none, "
        "candidates are tried one at a time, each at least once, and no proof is built on the union.",
        "nothing if a scene was found; else reduce the pools, or give things ranges that keep them apart",
    ),
    "scene/too-many": CodeInfo(
        "error",
        "The program asks for more things or combinations than the compiler takes",
        "The bound keeps a slip of the pen from filling the memory.",
        "lower `count`, leave out candidates, or give things ranges that keep them apart: what cannot meet is not "
        "multiplied",
    ),
    # Verdicts.
    "scene/relation-cycle": CodeInfo(
        "error",
        "Directional relations form a circle",
        "If a is left of b and b left of c, then c cannot be left of a, wherever they stand.",
        "drop or turn round one of the relations named",
    ),
    "scene/too-wide": CodeInfo(
        "error",
        "What must fit is wider than its place",
        "A footprint, or a row of footprints with their gaps, is wider than the support at every allowed heading.",
        "use a larger support or smaller assets, widen the ranges, or drop a relation of the row",
    ),
    "scene/area-bound": CodeInfo(
        "error",
        "The footprints need more area than there is",
        "Footprints grown by half the clearance cannot overlap, so their areas add up.",
        "remove things, lower the clearance, or use a larger support",
    ),
    "scene/empty-region": CodeInfo(
        "error",
        "No pose is left for a thing",
        "Its ranges, the edge of its support, keep-outs and what must stand there leave no room at any heading.",
        "widen the ranges, or move what is in the way",
    ),
    "scene/empty-domain": CodeInfo(
        "error",
        "None of the listed poses or slots can be used",
        "Every one of them is off the support, taken or in conflict with a relation.",
        "add a pose or a slot",
    ),
    "scene/infeasible": CodeInfo(
        "error",
        "There is no such scene",
        "The program was proved to have no solution; the conflict names what cannot hold together.",
        "drop or relax one of the constraints named",
    ),
    "scene/budget-exhausted": CodeInfo(
        "error",
        "No scene was found within the budget",
        "This is no proof that there is none. The report says how many things could be placed and which one kept "
        "failing.",
        "raise the budget, or relax what is asked of the thing named",
    ),
}
