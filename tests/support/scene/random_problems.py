"""Random problems by seed: small ones, more than half of them infeasible; mixed ones, mostly feasible; ones with
trays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import box

from scenec.ir.problem import Problem
from schemas.scene.geometry import KeepOutVolume, ReachRing, SceneRelation
from tests.support.scene.proof_problems import ANY, box_body, problem, table, thing

CM = 0.01
OFF_GRID_M = 0.006  # so that no bound is met exactly, in a single pose


def random_problem(seed: int) -> Problem:
    """Two to four boxes with sides of whole centimetres; relations, ranges, a keep-out, reach, each sometimes."""
    rng = np.random.default_rng(seed)
    free_yaw = rng.random() < 0.3
    count = 2 if free_yaw else int(rng.choice([2, 3, 3, 4]))
    width, depth = CM * rng.integers(14, 25), CM * rng.integers(10, 17)
    place = table(width, depth)
    things = []
    for k in range(count):
        size = CM * rng.integers(4, 9, 2)
        ranges = {}
        for axis, extent in (("x", width), ("y", depth)):
            if rng.random() < 0.2:
                low = CM * rng.integers(0, round(extent / CM)) - extent / 2
                ranges[axis] = (low, low + CM * rng.integers(0, 6))
        yaw = (0.0, 0.0)
        if free_yaw:
            yaw = (-np.pi, np.pi) if rng.random() < 0.6 else (0.0, float(rng.choice([0.3, 0.8])))
        elif rng.random() < 0.3:
            yaw = (np.pi / 2, np.pi / 2)
        things.append(thing(f"o{k}", tuple(size), place, yaw=yaw, **ranges))
    relations = [_relation(rng, n, count) for n in range(int(rng.choice([0, 1, 2, 3], p=[0.2, 0.3, 0.3, 0.2])))]
    rules = {}
    if rng.random() < 0.2:
        x, y = (
            CM * rng.integers(0, round(width / CM) - 3) - width / 2,
            CM * rng.integers(0, round(depth / CM) - 3) - depth / 2,
        )
        polygon = box(x, y, x + CM * rng.integers(3, 8), y + CM * rng.integers(3, 8))
        rules["keep_outs"] = (KeepOutVolume("background", place, polygon, 0.1, ("keep_outs", 0)),)
    if rng.random() < 0.15:
        base = np.array([0.0, -depth / 2 - 0.05, 0.0])
        rules["reach"] = ReachRing(base, 0.05, CM * rng.integers(6, 20), ("o0", "o1"), ("reach",))
    return problem(things, relations, float(rng.choice([0.0, 0.01, 0.02])), **rules)


def mixed_problem(seed: int) -> Problem:
    """Two to thirteen boxes at free headings that cover an eighth to two fifths of a table; in one of three a tray
    with two to four more; relations, ranges, a keep-out, each sometimes."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 13))
    sizes = rng.uniform(0.04, 0.12, (count, 2))
    area = float(sizes.prod(axis=1).sum()) / rng.uniform(0.12, 0.4)
    width = float(np.sqrt(area * rng.uniform(1.0, 2.0)))
    place = table(width, area / width)
    things = []
    for k, size in enumerate(sizes):
        x = (-width / 2, float(rng.uniform(-0.2, 0.5)) * width) if rng.random() < 0.15 else ANY
        yaw = (0.0, 0.0) if rng.random() < 0.3 else (-np.pi, np.pi)
        things.append(thing(f"o{k}", (float(size[0]), float(size[1])), place, x=x, yaw=yaw))
    if rng.random() < 0.33:
        tray = box_body("tray", 0.3, 0.22, 0.02, holds=True)
        big = table(width + 0.45, max(area / width, 0.45))
        things = [replace(item, place=big) for item in things]
        things.append(thing("tray", tray, big, yaw=(-np.pi, np.pi)))
        small = rng.uniform(0.03, 0.07, (int(rng.integers(2, 5)), 2))
        for k, size in enumerate(small):
            things.append(thing(f"t{k}", tuple(size), tray.surfaces[0], parent="tray", yaw=(-np.pi, np.pi)))
    relations = [_relation(rng, n, count) for n in range(int(rng.integers(0, count // 2 + 1)))]
    rules = {}
    if rng.random() < 0.2:
        x, y = rng.uniform(-0.5, 0.3, 2) * [width, area / width]
        polygon = box(x, y, x + 0.15 * width, y + 0.15 * area / width)
        rules["keep_outs"] = (KeepOutVolume("background", place, polygon, 0.1, ("keep_outs", 0)),)
    return problem(things, relations, float(rng.choice([0.0, 0.005, 0.01])), **rules)


def _relation(rng: np.random.Generator, number: int, count: int) -> SceneRelation:
    one, two = (f"o{k}" for k in rng.choice(count, 2, replace=False))
    path = ("relations", number)
    kind = rng.choice(["before", "near", "far_from", "aligned", "facing"], p=[0.6, 0.1, 0.1, 0.1, 0.1])
    if kind == "before":
        direction = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)][rng.integers(4)]
        return SceneRelation("before", (one, two), direction, CM * int(rng.integers(0, 4)), path=path)
    if kind in ("near", "far_from"):
        return SceneRelation(kind, (one, two), gap_m=CM * int(rng.integers(1, 8)), path=path)
    if kind == "aligned":
        direction = [(1.0, 0.0), (0.0, 1.0)][rng.integers(2)]
        return SceneRelation("aligned", (one, two), direction, tolerance=CM * int(rng.integers(0, 2)), path=path)
    return SceneRelation("facing", (one, two), tolerance=float(rng.choice([0.2, 0.5])), path=path)


def tray_problem(seed: int) -> Problem:
    """A table with one or two trays that may move and turn, boxes on all of them, and one to three relations of any
    kind among boxes on different ones, some counted along the axes of a tray."""
    rng = np.random.default_rng([7, seed])
    place = table(1.1, 0.8)
    turn = (-np.pi, np.pi) if rng.random() < 0.6 else (0.0, 0.0)
    things = [thing(f"o{k}", tuple(rng.uniform(0.04, 0.1, 2)), place, yaw=turn) for k in range(int(rng.integers(1, 3)))]
    for name in "ab"[: int(rng.integers(1, 3))]:
        tray = box_body(f"tray_{name}", float(rng.uniform(0.2, 0.3)), float(rng.uniform(0.2, 0.3)), 0.02, holds=True)
        things.append(thing(f"tray_{name}", tray, place, yaw=turn if rng.random() < 0.7 else (0.0, 0.0)))
        for k in range(int(rng.integers(1, 3))):
            size = tuple(rng.uniform(0.03, 0.06, 2))
            things.append(thing(f"{name}{k}", size, tray.surfaces[0], parent=f"tray_{name}", yaw=turn))
    names = [item.name for item in things if not item.name.startswith("tray") or rng.random() < 0.2]
    frames = ["background", *(item.name for item in things if item.name.startswith("tray"))]
    relations = []
    for number in range(int(rng.integers(1, 4))):
        one, two, *more = (str(name) for name in rng.permutation(names))
        kind = str(rng.choice(["before", "near", "far_from", "aligned", "facing", "between"]))
        frame = str(rng.choice(frames)) if kind in ("before", "aligned") else "background"
        angle = float(rng.choice([0.0, np.pi / 2, 0.4]))
        relations.append(
            SceneRelation(
                kind if kind != "between" or more else "near",
                (one, two, more[0]) if kind == "between" and more else (one, two),
                (float(np.cos(angle)), float(np.sin(angle))),
                float(rng.uniform(0.02, 0.2)) if kind in ("near", "far_from", "between") else 0.01,
                {"facing": 0.4, "between": 0.03, "aligned": 0.02}.get(kind, 0.0),
                frame,
                ("relations", number),
            )
        )
    return problem(things, relations, 0.01)


def word_problem(kind: str, seed: int) -> Problem:
    """Two to four small boxes with one or two relations, one of them of this kind: `above` (with boxes on two boards,
    some over one another), `surrounding` or `in_line`. Small enough for all poses of a grid."""
    rng = np.random.default_rng([11, len(kind), seed])
    width, depth = CM * rng.integers(11, 17), CM * rng.integers(8, 13)
    count = {"above": 2, "surrounding": 4, "in_line": 3}[kind] if rng.random() < 0.6 else 3
    boards = [table(width, depth), replace(table(width, depth), name="board", origin_P_m=np.array([0.0, 0.0, 0.1]))]
    things = []
    for k in range(count):
        size = CM * rng.integers(2, 5, 2)
        x = (-CM * rng.integers(0, 8), CM * rng.integers(0, 8)) if rng.random() < 0.2 else ANY
        board = boards[rng.integers(2)] if kind == "above" else boards[0]
        height = CM * int(rng.integers(3, 8))
        things.append(thing(f"o{k}", tuple(size), board, yaw=(0.0, 0.0), height=height, x=x))
    names = tuple(f"o{k}" for k in rng.permutation(count))
    path = ("relations", 0)
    if kind == "above":
        relations = [SceneRelation("above", names[:2], gap_m=CM * int(rng.integers(0, 6)), path=path)]
        if rng.random() < 0.5:
            relations.append(SceneRelation("near", names[:2], gap_m=0.0, path=path))
    elif kind == "surrounding":
        even, off = 2.0 * np.pi / (count - 1), float(rng.choice([0.3, 0.6]))
        angle = (even - off, even + off) if rng.random() < 0.5 else (float(rng.uniform(0.7, 1.1)) * even, 2.0 * np.pi)
        relations = [SceneRelation("surrounding", names, path=path, angle_rad=angle)]
        if rng.random() < 0.5:
            relations += [
                SceneRelation("near", (names[0], o), gap_m=CM * int(rng.integers(1, 3)) + OFF_GRID_M) for o in names[1:]
            ]
    else:
        direction = [(1.0, 0.0), (0.0, 1.0)][rng.integers(2)]
        spacing = CM * int(rng.integers(2, 8)) if rng.random() < 0.7 else 0.0
        tolerance = CM * int(rng.integers(0, 2)) + OFF_GRID_M
        relations = [SceneRelation("in_line", names, direction, spacing, tolerance, path=path)]
    if rng.random() < 0.4:
        relations.append(_relation(rng, 1, count))
    return problem(things, relations, float(rng.choice([0.0, 0.01])))
