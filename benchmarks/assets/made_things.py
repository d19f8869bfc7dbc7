"""Household things in one closed shell, made of solids whose triangles keep the name of the part they come from.

Sizes are drawn from trade sizes with a seed. What the cutting solids leave (the inside of a vessel) is of the part that
was cut. Metres; each thing stands in the reference pose of its category.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection, Manifold, OpType
from numpy.random import Generator

from schemas.arrays import FloatArray, IntArray

SIDES = 48
Named = tuple[str, Manifold]


@dataclass(frozen=True)
class Thing:
    """A closed surface of points (n, 3) and triangles (m, 3), with the part (m,) each triangle is of, by index."""

    name: str
    category: str
    points: FloatArray
    triangles: IntArray
    parts: tuple[str, ...]
    owner: IntArray


def things(seed: int, draws: int) -> Iterator[Thing]:
    """Each kind of thing `draws` times, in other sizes."""
    for name, (category, make) in KINDS.items():
        rng = np.random.default_rng([seed, *name.encode()])
        for _ in range(draws):
            parts, cuts = make(rng)
            yield _thing(name, category, parts, cuts)


def _thing(name: str, category: str, parts: Sequence[Named], cuts: Sequence[Named]) -> Thing:
    solids = [(label, solid.as_original()) for label, solid in parts]
    tools = [(label, solid.as_original()) for label, solid in cuts]
    made = Manifold.batch_boolean([s for _, s in solids], OpType.Add)
    for _, tool in tools:
        made = made - tool
    mesh = made.to_mesh64()
    labels = tuple(dict.fromkeys(label for label, _ in parts))
    of_run = {s.original_id(): labels.index(label) for label, s in (*solids, *tools)}
    runs = np.diff(np.asarray(mesh.run_index)) // 3
    owner = np.repeat([of_run[i] for i in mesh.run_original_id], runs)
    points = np.array(mesh.vert_properties)[:, :3].copy()
    return Thing(name, category, points, np.array(mesh.tri_verts).astype(np.int32), labels, owner)


def _turned(outline: Sequence[tuple[float, float]]) -> Manifold:
    """Solid of revolution about z of an outline of (radius, height)."""
    return Manifold.revolve(CrossSection([np.array(outline)]), SIDES)


def _box(x: float, y: float, z: float, at: tuple[float, float, float]) -> Manifold:
    """A box with its lower middle at `at`."""
    return Manifold.cube((x, y, z)).translate((at[0] - x / 2, at[1] - y / 2, at[2]))


def _rod(start: Sequence[float], end: Sequence[float], radius: float, last: float | None = None) -> Manifold:
    """A rod with round ends between two points; it tapers to `last` where that is given."""
    ends = [
        Manifold.sphere(r, 24).translate((float(p[0]), float(p[1]), float(p[2])))
        for p, r in ((start, radius), (end, radius if last is None else last))
    ]
    return Manifold.batch_hull(ends)


def _bow(points: Sequence[Sequence[float]], radius: float) -> Manifold:
    rods = [_rod(a, b, radius) for a, b in itertools.pairwise(points)]
    return Manifold.batch_boolean(rods, OpType.Add)


def _side_bow(out: float, reach: float, low: float, high: float, radius: float) -> Manifold:
    """A bow on the +x side, from the wall at `out`, `reach` away from it."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 9)
    path = np.column_stack(
        [out + reach * np.cos(angle), 0 * angle, (low + high) / 2 + (high - low) / 2 * np.sin(angle)]
    )
    return _bow([tuple(p) for p in path], radius)


def _mug(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h, wall = rng.uniform(0.035, 0.05), rng.uniform(0.08, 0.11), rng.uniform(0.003, 0.006)
    bow = _side_bow(r - wall / 2, rng.uniform(0.025, 0.035), 0.2 * h, 0.8 * h, rng.uniform(0.004, 0.007))
    inside = Manifold.cylinder(h, r - wall, circular_segments=SIDES).translate((0, 0, wall))
    return [("body", Manifold.cylinder(h, r, circular_segments=SIDES)), ("handle", bow)], [("body", inside)]


def _square_mug(rng: Generator) -> tuple[list[Named], list[Named]]:
    a, h, wall = rng.uniform(0.07, 0.09), rng.uniform(0.08, 0.11), rng.uniform(0.004, 0.006)
    bow = _side_bow(a / 2 - wall / 2, rng.uniform(0.025, 0.035), 0.2 * h, 0.8 * h, rng.uniform(0.004, 0.007))
    inside = _box(a - 2 * wall, a - 2 * wall, h, (0, 0, wall))
    return [("body", _box(a, a, h, (0, 0, 0))), ("handle", bow)], [("body", inside)]


def _jug(rng: Generator) -> tuple[list[Named], list[Named]]:
    """Oblong like a milk jug, so that its outline is no circle."""
    x, y, h, wall = rng.uniform(0.13, 0.16), rng.uniform(0.07, 0.09), rng.uniform(0.18, 0.24), 0.004
    bow = _side_bow(x / 2 - wall, rng.uniform(0.035, 0.045), 0.3 * h, 0.85 * h, rng.uniform(0.008, 0.012))
    return [("body", _box(x, y, h, (0, 0, 0))), ("handle", bow)], [
        ("body", _box(x - 2 * wall, y - 2 * wall, h, (0, 0, wall)))
    ]


def _teapot(rng: Generator) -> tuple[list[Named], list[Named]]:
    r = rng.uniform(0.06, 0.08)
    body = Manifold.sphere(r, SIDES).scale((1, 1, 0.85)).translate((0, 0, 0.8 * r))
    bow = _side_bow(0.9 * r, 0.6 * r, 0.4 * r, 1.2 * r, rng.uniform(0.006, 0.009)).rotate((0, 0, 180))
    spout = _rod((0.75 * r, 0, 0.7 * r), (1.75 * r, 0, 1.5 * r), 0.26 * r, 0.12 * r)
    return [("body", body), ("handle", bow), ("spout", spout)], []


def _pan(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h, wall = rng.uniform(0.1, 0.15), rng.uniform(0.04, 0.1), rng.uniform(0.003, 0.005)
    length, thick = rng.uniform(0.14, 0.2), rng.uniform(0.007, 0.011)
    handle = _rod((r - wall / 2, 0, 0.8 * h), (r + length, 0, h), thick)
    inside = Manifold.cylinder(h, r - wall, circular_segments=SIDES).translate((0, 0, wall))
    return [("body", Manifold.cylinder(h, r, circular_segments=SIDES)), ("handle", handle)], [("body", inside)]


def _grill_pan(rng: Generator) -> tuple[list[Named], list[Named]]:
    a, h, wall = rng.uniform(0.22, 0.28), rng.uniform(0.03, 0.05), 0.004
    handle = _rod((a / 2 - wall / 2, 0, 0.7 * h), (a / 2 + rng.uniform(0.15, 0.2), 0, h), rng.uniform(0.008, 0.011))
    return [("body", _box(a, a, h, (0, 0, 0))), ("handle", handle)], [
        ("body", _box(a - 2 * wall, a - 2 * wall, h, (0, 0, wall)))
    ]


def _pot(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h, wall = rng.uniform(0.09, 0.14), rng.uniform(0.1, 0.18), 0.004
    parts: list[Named] = [("body", Manifold.cylinder(h, r, circular_segments=SIDES))]
    angle = np.linspace(-np.pi / 2, np.pi / 2, 9)
    reach, half, thick = rng.uniform(0.03, 0.045), rng.uniform(0.035, 0.05), rng.uniform(0.005, 0.008)
    path = [(r - wall / 2 + reach * np.cos(t), half * np.sin(t), 0.8 * h) for t in angle]
    parts += [("handle", _bow(path, thick)), ("handle", _bow(path, thick).rotate((0, 0, 180)))]
    inside = Manifold.cylinder(h, r - wall, circular_segments=SIDES).translate((0, 0, wall))
    return parts, [("body", inside)]


def _basket(rng: Generator) -> tuple[list[Named], list[Named]]:
    x, y, h, wall = rng.uniform(0.3, 0.42), rng.uniform(0.2, 0.28), rng.uniform(0.12, 0.18), 0.008
    angle = np.linspace(0, np.pi, 13)
    rise, half = rng.uniform(0.15, 0.22), x / 2 - wall / 2
    path = [(half * np.cos(t), 0.0, h - 0.01 + rise * np.sin(t)) for t in angle]
    return [("body", _box(x, y, h, (0, 0, 0))), ("handle", _bow(path, rng.uniform(0.008, 0.012)))], [
        ("body", _box(x - 2 * wall, y - 2 * wall, h, (0, 0, wall)))
    ]


def _spoon(rng: Generator) -> tuple[list[Named], list[Named]]:
    length, a, b = rng.uniform(0.14, 0.2), rng.uniform(0.028, 0.038), rng.uniform(0.018, 0.022)
    bowl = Manifold.sphere(1.0, SIDES).scale((a, b, 0.008)).translate((0, 0, 0.008))
    hollow = Manifold.sphere(1.0, SIDES).scale((a - 0.002, b - 0.002, 0.008)).translate((0, 0, 0.0095))
    handle = _box(length - 2 * a, rng.uniform(0.008, 0.012), 0.003, (a + (length - 2 * a) / 2 - 0.004, 0, 0.006))
    return [("bowl", bowl), ("handle", handle)], [("bowl", hollow)]


def _fork(rng: Generator) -> tuple[list[Named], list[Named]]:
    length, wide, head = rng.uniform(0.16, 0.2), rng.uniform(0.022, 0.027), rng.uniform(0.055, 0.07)
    slots = [("tines", _box(0.7 * head, 0.003, 0.02, (-0.65 * head, y, -0.005))) for y in (-wide / 4, 0, wide / 4)]
    handle = _box(length - head, rng.uniform(0.007, 0.011), 0.003, ((length - head) / 2 - 0.001, 0, 0))
    return [("tines", _box(head, wide, 0.003, (-head / 2, 0, 0))), ("handle", handle)], slots


def _knife(rng: Generator) -> tuple[list[Named], list[Named]]:
    blade, grip = rng.uniform(0.1, 0.2), rng.uniform(0.09, 0.13)
    high = rng.uniform(0.02, 0.04)
    edge = [(0.0, 0.0), (blade, 0.3 * high), (blade, 0.35 * high), (0.6 * blade, high), (0.0, high)]
    leaf = Manifold.extrude(CrossSection([np.array(edge)]), rng.uniform(0.0015, 0.003))
    thick = rng.uniform(0.012, 0.018)
    handle = _box(grip, rng.uniform(0.7, 1.0) * high, thick, (-grip / 2 + 0.001, high / 2, -thick / 2 + 0.001))
    return [("blade", leaf), ("handle", handle)], []


def _spatula(rng: Generator) -> tuple[list[Named], list[Named]]:
    length, wide, head = rng.uniform(0.28, 0.36), rng.uniform(0.06, 0.09), rng.uniform(0.08, 0.11)
    handle = _rod((0, 0, 0), (length - head, 0, 0.03), rng.uniform(0.006, 0.01))
    return [("head", _box(head, wide, 0.003, (-head / 2 + 0.004, 0, -0.0015))), ("handle", handle)], []


def _ladle(rng: Generator) -> tuple[list[Named], list[Named]]:
    r = rng.uniform(0.04, 0.05)
    ball = Manifold.sphere(r, SIDES)
    half = ball.trim_by_plane((0, 0, -1), 0.0)
    handle = _rod((r - 0.002, 0, -0.004), (r + rng.uniform(0.2, 0.26), 0, rng.uniform(0.0, 0.06)), 0.006)
    return [("head", half), ("handle", handle)], [("head", Manifold.sphere(r - 0.003, SIDES))]


def _hammer(rng: Generator) -> tuple[list[Named], list[Named]]:
    length, wide, thick = rng.uniform(0.27, 0.35), rng.uniform(0.09, 0.13), rng.uniform(0.022, 0.03)
    head = _box(thick, wide, thick, (0, 0, -thick / 2))
    handle = _rod((0, 0, 0), (length, 0, 0), rng.uniform(0.010, 0.014), rng.uniform(0.013, 0.017))
    return [("head", head), ("handle", handle)], []


def _screwdriver(rng: Generator) -> tuple[list[Named], list[Named]]:
    grip, shaft, thick = rng.uniform(0.09, 0.11), rng.uniform(0.08, 0.16), rng.uniform(0.013, 0.017)
    return [
        ("handle", _rod((0, 0, 0), (-grip + 2 * thick, 0, 0), thick)),
        ("shaft", _rod((0, 0, 0), (shaft + thick, 0, 0), rng.uniform(0.002, 0.0035))),
    ], []


def _capped_bottle(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h, cap = rng.uniform(0.03, 0.045), rng.uniform(0.16, 0.24), rng.uniform(0.35, 0.5)
    body = _turned([(0, 0), (r, 0), (r, 0.78 * h), (0.8 * r, 0.86 * h), (0.6 * cap * r, 0.9 * h), (0, 0.9 * h)])
    top = Manifold.cylinder(rng.uniform(0.015, 0.02), cap * r, circular_segments=SIDES).translate((0, 0, 0.9 * h))
    return [("body", body), ("cap", top)], []


def _wine_bottle(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h, neck = rng.uniform(0.036, 0.04), rng.uniform(0.28, 0.32), rng.uniform(0.013, 0.015)
    body = _turned([(0, 0), (r, 0), (r, 0.58 * h), (0.9 * r, 0.64 * h), (neck, 0.72 * h), (0, 0.72 * h)])
    top = Manifold.cylinder(0.28 * h, neck, circular_segments=SIDES).translate((0, 0, 0.72 * h))
    wall = 0.003
    inside = _turned(
        [(0, wall), (r - wall, wall), (r - wall, 0.57 * h), (neck - wall, 0.71 * h), (neck - wall, h), (0, h)]
    )
    return [("body", body), ("neck", top)], [("body", inside)]


def _wine_glass(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, bowl, stem = rng.uniform(0.03, 0.045), rng.uniform(0.08, 0.11), rng.uniform(0.06, 0.1)
    foot = Manifold.cylinder(0.004, rng.uniform(0.85, 1.0) * r, circular_segments=SIDES)
    rod = Manifold.cylinder(stem, 0.004, circular_segments=SIDES).translate((0, 0, 0.002))
    base = 0.004 + stem
    cup = _turned([(0, base), (0.4 * r, base), (r, base + 0.45 * bowl), (0.8 * r, base + bowl), (0, base + bowl)])
    hollow = _turned(
        [
            (0, base + 0.004),
            (0.36 * r, base + 0.004),
            (r - 0.002, base + 0.45 * bowl),
            (0.8 * r - 0.002, base + bowl),
            (0, base + bowl),
        ]
    )
    return [("foot", foot), ("stem", rod), ("bowl", cup)], [("bowl", hollow)]


def _bowl(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h = rng.uniform(0.06, 0.13), rng.uniform(0.04, 0.09)
    outer = _turned([(0, 0), (0.5 * r, 0), (r, h), (0, h)])
    return [("body", outer)], [("body", _turned([(0, 0.004), (0.5 * r - 0.003, 0.004), (r - 0.004, h), (0, h)]))]


def _tumbler(rng: Generator) -> tuple[list[Named], list[Named]]:
    r, h = rng.uniform(0.03, 0.045), rng.uniform(0.08, 0.14)
    outer = _turned([(0, 0), (0.75 * r, 0), (r, h), (0, h)])
    return [("body", outer)], [("body", _turned([(0, 0.004), (0.75 * r - 0.002, 0.004), (r - 0.002, h), (0, h)]))]


def _straight_bottle(rng: Generator) -> tuple[list[Named], list[Named]]:
    return [("body", Manifold.cylinder(rng.uniform(0.12, 0.2), rng.uniform(0.03, 0.04), circular_segments=SIDES))], []


def _straight_stick(rng: Generator) -> tuple[list[Named], list[Named]]:
    """Chopstick, skewer: tapers without a step."""
    return [("body", _rod((0, 0, 0), (rng.uniform(0.2, 0.3), 0, 0), 0.005, rng.uniform(0.002, 0.005)))], []


# What it is -> its category and how it is made; the last five have no parts to be told apart.
KINDS: dict[str, tuple[str, Callable[[Generator], tuple[list[Named], list[Named]]]]] = {
    "mug": ("mug", _mug),
    "square mug": ("mug", _square_mug),
    "oblong jug": ("pitcher", _jug),
    "teapot": ("teapot", _teapot),
    "pan": ("pan", _pan),
    "square grill pan": ("pan", _grill_pan),
    "pot with two handles": ("pot", _pot),
    "basket": ("basket", _basket),
    "spoon": ("spoon", _spoon),
    "fork": ("fork", _fork),
    "knife": ("knife", _knife),
    "spatula": ("cooking_utensil", _spatula),
    "ladle": ("cooking_utensil", _ladle),
    "hammer": ("hammer", _hammer),
    "screwdriver": ("screwdriver", _screwdriver),
    "bottle with cap": ("bottle", _capped_bottle),
    "wine bottle": ("bottle", _wine_bottle),
    "wine glass": ("drinking_glass", _wine_glass),
    "bowl": ("bowl", _bowl),
    "tumbler": ("cup", _tumbler),
    "straight bottle": ("bottle", _straight_bottle),
    "tumbler called mug": ("mug", _tumbler),
    "stick": ("cooking_utensil", _straight_stick),
}
