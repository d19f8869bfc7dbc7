"""Diagnostic codes of scene groups that place their members relative to one another; part of the table in
`schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

SCENE_GROUP_CODES: dict[str, CodeInfo] = {
    "scene/stack-unsteady": CodeInfo(
        "error",
        "A stack may fall within the poses that it allows",
        "A plan draws every pose within the alignment. At some of them the middle of a thing, or of one above it, is "
        "not over what carries it.",
        "take a smaller `alignment`, a broader thing below, or fewer things",
    ),
    "scene/grid-size": CodeInfo(
        "error",
        "The members of a grid do not fill its cells",
        "A grid has one member for each cell, or one that is copied into all of them; else it would be open which "
        "cells stay empty.",
        "name as many members as rows times columns, or a single one",
    ),
    "scene/unknown-part": CodeInfo(
        "error",
        "An asset has no part or affordance of that name",
        "The direction in which a part lies comes from the record of the asset; without the part there is none.",
        "take one of the parts listed; `mana assets show ID` shows them, and inline assets have none",
    ),
    "scene/part-without-direction": CodeInfo(
        "error",
        "A part lies in no direction from the origin of its object",
        "A direction in the plane is defined for a part beside the origin of an object that stands upright.",
        "name a part that lies to one side, or turn the front: `facing: [a, b]`",
    ),
    "scene/distractor-overlap": CodeInfo(
        "error",
        "A distractor is an asset of the task or of the evaluation",
        "A policy that meets the objects of the task, or those held out, as background clutter is measured on what it "
        "has seen.",
        "take the asset out of the pool, or out of the task or the split",
    ),
    "scene/distractor-named": CodeInfo(
        "error",
        "A distractor is named where an object must be there",
        "Each draw leaves out some distractors: a relation or an anchor with one of them would have no meaning there.",
        "declare the object under `objects`, with a node of its own",
    ),
    "scene/no-view": CodeInfo(
        "error",
        "No drawn camera shows what it must in the compiled scene",
        "Cameras are drawn within their ranges until each object is seen with the pixels demanded. Where no try does, "
        "plans would have no view either; this is no proof that there is none.",
        "widen the ranges, look at the object, ask for fewer pixels, or move what stands before it",
    ),
    "scene/robot-reach": CodeInfo(
        "error",
        "The reach of a named robot is not computed",
        "A robot reaches what its inverse kinematics reaches without a collision; the language has a ring about it.",
        "write the ring: `reach: {base, radius, min_radius, members}`",
    ),
    "scene/joint-state-range": CodeInfo(
        "error",
        "A joint has a range of states",
        "Footprint, surfaces and insides are those of one state of the joints; over a range they would all move.",
        "write one state, and one program or background of `variants` for each further one",
    ),
}
