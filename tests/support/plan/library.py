"""Small plans made by hand, for tests of what draws from plans."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from schemas.scene.geometry import Prism
from schemas.scene.program import BoxAsset, Lighting, PairedMaterial
from schemas.scene.runtime_plan import (
    PlanBody,
    PlanCase,
    PlanCombination,
    PlanPlace,
    PlanPolygon,
    PlanPool,
    PlanProvenance,
    PlanStance,
    PlanThing,
    RuntimePlan,
)

TURN_URAD = 3_141_593
FREE = ((-TURN_URAD, TURN_URAD),)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
PLATE_UM = (250_000, 250_000, -9_000, 90_000)  # where the middle of the plate may be, on the table of `tray_plan`
MADE = PlanProvenance(program="by hand", program_hash="", compiler="test", seed=0)


def box_body(
    name: str, width_m: float, depth_m: float, height_m: float = 0.05, mass_kg: float | None = None
) -> PlanBody:
    """A box; upright, or lying on its side so that its height is its width in x."""
    primitive = BoxAsset(type="box", size_m=(width_m, depth_m, height_m), mass_kg=mass_kg)
    root = 0.5**0.5
    up = PlanStance(name="upright", quat_wxyz=UPRIGHT, origin_height_m=0.0, prisms=(slab(width_m, depth_m, height_m),))
    # Turned by a quarter about y: +x of the asset points down, its top to +x; the origin lies in mid-side.
    side = Prism(
        outline_m=np.array(
            ((0.0, -depth_m / 2), (height_m, -depth_m / 2), (height_m, depth_m / 2), (0.0, depth_m / 2))
        ),
        low_m=0.0,
        high_m=width_m,
    )
    lying = PlanStance(name="side", quat_wxyz=(root, 0.0, root, 0.0), origin_height_m=width_m / 2, prisms=(side,))
    return PlanBody(asset_id=name, primitive=primitive, mass_kg=mass_kg, stances=(up, lying))


def round_body(name: str, radius_m: float, corners: int, height_m: float = 0.03) -> PlanBody:
    """A prism over a regular polygon."""
    turns = 2.0 * np.pi * np.arange(corners) / corners
    outline = tuple((round(radius_m * float(np.cos(t)), 9), round(radius_m * float(np.sin(t)), 9)) for t in turns)
    prism = Prism(outline_m=np.array(outline), low_m=0.0, high_m=height_m)
    return PlanBody(
        asset_id=name,
        stances=(PlanStance(name="upright", quat_wxyz=UPRIGHT, origin_height_m=0.0, prisms=(prism,)),),
    )


def slab(width_m: float, depth_m: float, height_m: float) -> Prism:
    """A box as a prism."""
    return Prism(outline_m=np.array(rectangle(width_m, depth_m)), low_m=0.0, high_m=height_m)


def rectangle(width_m: float, depth_m: float) -> tuple[tuple[float, float], ...]:
    """Its corners, counter-clockwise."""
    x, y = width_m / 2, depth_m / 2
    return ((-x, -y), (x, -y), (x, y), (-x, y))


def surface(name: str, width_m: float, depth_m: float, origin_m: tuple[float, float, float]) -> PlanPlace:
    """A rectangle to stand on."""
    return PlanPlace(
        name=name, kind="surface", origin_m=origin_m, polygon=PlanPolygon(outline_m=rectangle(width_m, depth_m))
    )


_STEPS_MRAD = np.arange(-3141, 3142)


def yaws_that_fit(body: PlanBody, width_um: int, depth_um: int) -> tuple[tuple[int, int], ...]:
    """Yaws at which the upright footprint fits a cell, in steps of a milliradian."""
    width_m, depth_m = _turned_extents_m(body.stances[0].prisms[0])
    fits = (width_m <= width_um * 1e-6) & (depth_m <= depth_um * 1e-6)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], fits, [False]]).astype(int)))
    return tuple((int(_STEPS_MRAD[a]) * 1000, int(_STEPS_MRAD[b - 1]) * 1000) for a, b in edges.reshape(-1, 2))


@functools.cache
def _turned_extents_m(prism: Prism) -> tuple[np.ndarray, np.ndarray]:
    """Extents in x and y (steps,) of a prism at each yaw."""
    corners, turns = prism.outline_m, _STEPS_MRAD * 1e-3
    x = np.outer(corners[:, 0], np.cos(turns)) - np.outer(corners[:, 1], np.sin(turns))
    y = np.outer(corners[:, 0], np.sin(turns)) + np.outer(corners[:, 1], np.cos(turns))
    return np.ptp(x, axis=0), np.ptp(y, axis=0)


def grid_plan(n: int, cases: int, seed: int = 0, bodies: tuple[PlanBody, ...] | None = None) -> RuntimePlan:
    """n boxes on a table of 1.2 x 0.8 m, each in a cell of a jittered grid; which box in which cell changes by case."""
    rng = np.random.default_rng([n, seed])
    columns = int(np.ceil(np.sqrt(1.5 * n)))
    rows = -(-n // columns)
    least = 0.8 * min(1.2 / columns, 0.8 / rows) - 0.01
    if bodies is None:
        sizes = rng.uniform(0.4 * least, 0.95 * least, size=(n, 2)).round(3)
        bodies = tuple(box_body(f"box{i}", *size.tolist()) for i, size in enumerate(sizes))
    made = tuple(_grid_case(rng, bodies, columns, rows) for _ in range(cases))
    names = tuple(f"thing{i}" for i in range(n))
    combination = PlanCombination(
        X_WB=((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        places=(("background", surface("top", 1.2, 0.8, (0.0, 0.0, 0.7))),),
        things=tuple(PlanThing(id=name, bodies=(i,), parent="background", place=0) for i, name in enumerate(names)),
        pools=(PlanPool(things=names, cases=made),),
    )
    return RuntimePlan(scene=f"grid{n}", clearance_m=0.01, bodies=bodies, combinations=(combination,), provenance=MADE)


def _grid_case(rng: np.random.Generator, bodies: tuple[PlanBody, ...], columns: int, rows: int) -> PlanCase:
    xs, ys = (_edges(rng, count, total_um) for count, total_um in ((columns, 1_200_000), (rows, 800_000)))
    chosen = rng.permutation(columns * rows)[: len(bodies)].tolist()
    cells, yaws = [], []
    for body, cell in zip(bodies, chosen, strict=True):
        row, column = divmod(cell, columns)
        x_low, x_high, y_low, y_high = xs[column] + 5000, xs[column + 1] - 5000, ys[row] + 5000, ys[row + 1] - 5000
        cells.append((x_low, x_high, y_low, y_high))
        yaws.append(yaws_that_fit(body, x_high - x_low, y_high - y_low))
    n = len(bodies)
    return PlanCase(
        family="grid", cells_um=tuple(cells), origins_um=(None,) * n, yaws_urad=tuple(yaws), stances=(0,) * n,
        base_um=(0,) * n,
    )  # fmt: skip


def _edges(rng: np.random.Generator, count: int, total_um: int) -> list[int]:
    even = np.arange(count + 1) * total_um / count - total_um / 2
    even[1:-1] += rng.uniform(-0.1, 0.1, count - 1) * total_um / count
    return [round(edge) for edge in even.tolist()]


def single(name: str, cell_um: tuple[int, int, int, int], *, stance: int = 0, **more: Any) -> PlanPool:
    """A pool of one thing with one cell and free yaw."""
    case = PlanCase(
        family="free_rectangle",
        cells_um=(cell_um,),
        origins_um=(more.get("origin"),),
        yaws_urad=(more.get("yaws", FREE),),
        stances=(stance,),
        base_um=(0,),
    )
    return PlanPool(things=(name,), cases=(case,))


def tray_plan() -> RuntimePlan:
    """Every construct at once: a turned background, a tray that carries a cup of two kinds and a lying block, a plate;
    two combinations (the second has no plate), three materials, two lightings."""
    bodies = (
        box_body("table", 1.2, 0.8, 0.7),
        box_body("tray", 0.4, 0.3, 0.02, mass_kg=0.5),
        box_body("cup_a", 0.08, 0.06, 0.1, mass_kg=0.2),
        box_body("cup_b", 0.06, 0.06, 0.12, mass_kg=0.3),
        box_body("block", 0.05, 0.04, 0.1, mass_kg=0.1),
        round_body("plate", 0.1, 24),
    )
    places = (
        ("background", surface("top", 1.2, 0.8, (0.0, 0.0, 0.7))),
        ("tray", surface("top", 0.4, 0.3, (0.0, 0.0, 0.02))),
    )
    things = (
        PlanThing(id="tray", bodies=(1,), parent="background", place=0),
        PlanThing(id="plate", bodies=(5,), parent="background", place=0, yaw_rad=(0.0, 0.0)),
        PlanThing(id="cup", bodies=(2, 3), parent="tray", place=1),
        PlanThing(id="block", bodies=(4,), parent="tray", place=1, stances=(0, 1)),
    )
    upright = single("block", (20_000, 195_000, -145_000, 145_000))
    lying = single("block", (20_000, 195_000, -145_000, 145_000), stance=1)
    pools = (
        single("tray", (-590_000, 0, -390_000, 390_000), yaws=((-200_000, 200_000), (3_000_000, 3_200_000))),
        single(
            "plate", (100_000, 590_000, -390_000, 390_000), yaws=((0, 0),), origin=(250_000, 250_000, -9_000, 90_000)
        ),
        single("cup", (-195_000, 0, -145_000, 145_000)),
        PlanPool(
            things=("block",),
            cases=(upright.cases[0].model_copy(update={"weight": 3.0}), lying.cases[0]),
        ),
    )
    c, s = 0.8775825618903728, 0.479425538604203  # of 0.5 rad
    turned = ((c, -s, 0.0, 0.3), (s, c, 0.0, -0.2), (0.0, 0.0, 1.0, 0.1), (0.0, 0.0, 0.0, 1.0))
    first = PlanCombination(
        combination={"variants.assets": "as_written"}, weight=2.0, background=0, X_WB=turned, places=places,
        things=things, pools=pools, materials=("steel", "wood", "felt"), lighting=("noon", "dusk"),
    )  # fmt: skip
    without = PlanCombination(
        combination={"variants.assets": "no_plate"}, background=0, X_WB=turned, places=places,
        things=(things[0], things[2], things[3]), pools=(pools[0], pools[3], pools[2]), lighting=("dusk",),
    )  # fmt: skip
    materials = (
        PairedMaterial(id="steel", objects=("tray",), base_color=(0.7, 0.7, 0.7), density_kgm3=7800.0),
        PairedMaterial(id="wood", objects=("tray", "block"), base_color=(0.6, 0.4, 0.2), density_kgm3=600.0),
        PairedMaterial(id="felt", objects=("background",), base_color=(0.1, 0.4, 0.1), dynamic_friction=0.9),
    )
    lighting = (
        Lighting(id="noon", intensity=(800.0, 1200.0), temperature_K=(5000.0, 6500.0)),
        Lighting(id="dusk", intensity=(100.0, 200.0), exposure=(0.0, 1.0), rotation=(0.0, 6.0)),
    )
    return RuntimePlan(
        scene="tray", clearance_m=0.01, bodies=bodies, combinations=(first, without), materials=materials,
        lighting=lighting, provenance=MADE,
    )  # fmt: skip
