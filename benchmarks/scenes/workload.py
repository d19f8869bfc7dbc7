"""The tabletop workload of the scene benchmarks as problems: boxes of 4 to 14 cm, a table of 1.2 x 0.8 m."""

from __future__ import annotations

import numpy as np
from shapely import box

from scenec.ir.problem import Body, Problem, Thing
from schemas.scene.geometry import BACKGROUND, Domain, Prism, ScenePlace, SceneRelation, Stance

TABLE_M = (1.2, 0.8)
CLEARANCE_M = 0.01
SIDE_M = (0.04, 0.14)


def box_body(name: str, width_m: float, depth_m: float, height_m: float = 0.05, *, top: bool = False) -> Body:
    """A solid box standing upright, its frame at the middle of its bottom; with its top face as a surface on demand."""
    w, d = width_m / 2, depth_m / 2
    outline = np.array([(-w, -d), (w, -d), (w, d), (-w, d)])
    stance = Stance((1.0, 0.0, 0.0, 0.0), (Prism(outline, 0.0, height_m),), 0.0)
    surface = ScenePlace("top", box(-w, -d, w, d), np.array([0.0, 0.0, height_m]))
    return Body(name, (stance,), (surface,) if top else ())


def table(width_m: float = TABLE_M[0], depth_m: float = TABLE_M[1]) -> ScenePlace:
    """The top of a table at the background's origin."""
    return ScenePlace("top", box(-width_m / 2, -depth_m / 2, width_m / 2, depth_m / 2), np.zeros(3))


def sizes_and_pairs(n: int, seed: int) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Footprints (n, 2) in metres and n // 5 disjoint `left_of` pairs, as in the anchors' benchmark."""
    rng = np.random.default_rng([20250601, n, seed])
    sizes = rng.uniform(*SIDE_M, size=(n, 2))
    order = rng.permutation(n)
    return sizes, [(int(order[2 * i]), int(order[2 * i + 1])) for i in range(n // 5)]


def program_text(sizes: np.ndarray, pairs: list[tuple[int, int]]) -> str:
    """The same as a scene program, as people write it."""
    objects = [
        f"  - {{id: box{i}, asset: {{type: box, size_m: [{w:.4f}, {d:.4f}, 0.05]}}}}" for i, (w, d) in enumerate(sizes)
    ]
    nodes = [f"    box{i}: {{object: box{i}, placement: {{type: surface, surface: top}}}}" for i in range(len(sizes))]
    width, depth = TABLE_M
    return "\n".join(
        [
            f"background: {{asset: {{type: box, size_m: [{width}, {depth}, 0.04]}}}}",
            "anchors: {top: {object: background, surface: auto}}",
            *("objects:", *objects, "layout:", "  nodes:", *nodes, "relations:"),
            *(f"  - {{left_of: [box{a}, box{b}]}}" for a, b in pairs),
            f"clearance: {CLEARANCE_M}\n",
        ]
    )


def workload(n: int, seed: int, *, cycle: bool = False) -> Problem:
    """The problem of n boxes with free yaw; with `cycle` three `left_of` that contradict one another instead."""
    sizes, pairs = sizes_and_pairs(n, seed)
    if cycle:
        pairs = [(0, 1), (1, 2), (2, 0)]
    surface = table()
    things = tuple(
        Thing(f"box{i}", box_body(f"box{i}", *sizes[i]), BACKGROUND, surface, Domain(), ("layout", "nodes", f"box{i}"))
        for i in range(n)
    )
    relations = tuple(
        SceneRelation("before", (f"box{a}", f"box{b}"), path=("relations", k), word="left_of")
        for k, (a, b) in enumerate(pairs)
    )
    return Problem("workload", None, np.eye(4), things, relations, CLEARANCE_M)
