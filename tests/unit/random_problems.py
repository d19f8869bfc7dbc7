"""Random small problems, about half of them without a scene: boxes on a small table, by a seed."""

from __future__ import annotations

import numpy as np
from shapely import box

from scenec.ir import KeepOutIR, Problem, ReachIR, RelationIR
from tests.unit.proof_problems import problem, table, thing

CM = 0.01


def random_problem(seed: int) -> Problem:
    """Two to four boxes with sides of whole centimetres; relations, ranges, a keep-out, reach, each sometimes."""
    rng = np.random.default_rng(seed)
    free_yaw = rng.random() < 0.3
    count = 2 if free_yaw else int(rng.choice([2, 3, 3, 4]))
    width, depth = CM * rng.integers(12, 21), CM * rng.integers(9, 14)
    place = table(width, depth)
    things = []
    for k in range(count):
        size = CM * rng.integers(4, 9, 2)
        ranges = {}
        for axis, extent in (("x", width), ("y", depth)):
            if rng.random() < 0.3:
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
        rules["keep_outs"] = (KeepOutIR("background", place.name, polygon, 0.1, ("keep_outs", 0)),)
    if rng.random() < 0.15:
        base = np.array([0.0, -depth / 2 - 0.05, 0.0])
        rules["reach"] = ReachIR(base, 0.05, CM * rng.integers(6, 20), ("o0", "o1"), ("reach",))
    return problem(things, relations, float(rng.choice([0.0, 0.01, 0.02])), **rules)


def _relation(rng: np.random.Generator, number: int, count: int) -> RelationIR:
    one, two = (f"o{k}" for k in rng.choice(count, 2, replace=False))
    path = ("relations", number)
    kind = rng.choice(["before", "near", "far_from", "aligned", "facing"], p=[0.6, 0.1, 0.1, 0.1, 0.1])
    if kind == "before":
        direction = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)][rng.integers(4)]
        return RelationIR("before", (one, two), direction, CM * int(rng.integers(0, 4)), path=path)
    if kind in ("near", "far_from"):
        return RelationIR(kind, (one, two), gap_m=CM * int(rng.integers(1, 8)), path=path)
    if kind == "aligned":
        direction = [(1.0, 0.0), (0.0, 1.0)][rng.integers(2)]
        return RelationIR("aligned", (one, two), direction, tolerance=CM * int(rng.integers(0, 2)), path=path)
    return RelationIR("facing", (one, two), tolerance=float(rng.choice([0.2, 0.5])), path=path)
