"""The independent judge of one finished scene: plain arrays in, violations out; it imports no compiler and no solver.

An object is a set of convex prisms in the world W (metres, z up). Places are level, so frame A of a place is an origin
and a yaw in W. The rules, with tolerance `TOLERANCE_M` for lengths and the same number in rad for angles:

support     on a surface every outline lies on the polygon and the top under the free height; in a volume each prism
            lies within every layer that it spans and below the rim, on the floor or on other contents (see
            `scene_check.stacking`)
clearance   least distance of footprints between objects that overlap in height: whole footprints and whole heights for
            objects of one place, prism by prism otherwise. Between an object and its owners, or their
            owners, only the owner's geometry over the place (`above`) must not be entered
keep_clear  nothing is in the space that a joint sweeps but its owner, what the moved links carry, and what carries the
            owner
stacks      each thing of a stack stands on the one before it and balances, for any masses (see `scene_check.towers`)
grids       the members keep their places in a common frame, whose pose is within its ranges
ranges, stances, fixed poses, relations, keep-outs, reach (a ring in x and y). A fixed pose above the floor (a hook, a
            peg hole) needs no support beneath it: the program states that it holds.
"""

from __future__ import annotations

from scene_check.grids import disordered_grids
from scene_check.model import CheckScene, Violation, changed_since
from scene_check.pairs import too_close
from scene_check.placement import owners_entered, unsupported, wrong_pose
from scene_check.relations import broken_relation
from scene_check.stacking import unstable_stacks
from scene_check.towers import fallen_towers
from scene_check.zones import entered_keep_out, entered_swept_space, out_of_reach


def check(scene: CheckScene, known: CheckScene | None = None) -> tuple[Violation, ...]:
    """Every violation of the scene, in the order of its objects; none means that the scene is valid.

    `known` is a scene without violations. Objects identical (`is`) to those of `known` are judged only against the
    others.
    """
    by_name = {item.name: item for item in scene.objects}
    changed = changed_since(known, scene, by_name)
    judged_before = {id(relation) for relation in known.relations} if known is not None else set[int]()
    violations: list[Violation] = []
    for item in scene.objects:
        if item.name in changed:
            violations += (*wrong_pose(item), *unsupported(item), *owners_entered(item, by_name))
    violations += unstable_stacks(scene)
    violations += fallen_towers(scene.stacks, by_name)
    violations += disordered_grids(scene.grids, by_name)
    violations += too_close(scene, by_name, changed)
    for relation in scene.relations:
        if id(relation) not in judged_before or not changed.isdisjoint(relation.things):
            violations += broken_relation(relation, [by_name[name] for name in relation.things])
    for place, keep_out in scene.keep_outs:
        violations += entered_keep_out(place, keep_out, scene, by_name)
    for swept in scene.keep_clear:
        violations += entered_swept_space(swept, scene, by_name)
    if scene.reach is not None:
        violations += out_of_reach(scene.reach, by_name)
    return tuple(violations)
