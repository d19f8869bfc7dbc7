"""Small libraries of records without files, drawn from a seed: for laws of the catalog."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from typing import Any

SAMPLE = Path(__file__).parents[2] / "data" / "record.json"
CATEGORIES = ("mug", "bowl", "cabinet", "unknown", "thingamajig")
FAMILIES = {"mug": "drinkware", "bowl": "kitchenware"}
ROLES = ("receptacle", "manipulated", "mechanism")
MATERIALS = ("ceramic", "wood", "unknown", "steel")
NAMES = ("red mug", "Mug_v2", "чайник", "tray for mugs", "box", "CAN", "candle")
COLOURS = ("red", "blue", "white")
TASKS = (("spout", "pour", "tilt"), ("handle", "carry", "wrap"), ("lid", "open", "lift_off"))
JOINTS = ("revolute", "prismatic")
GROUPS = ("drawer", "hinged_door", "unknown")


def evidence(value: object, confidence: float) -> dict[str, Any]:
    return {"value": value, "source": "inferred", "method": "test", "confidence": confidence}


def random_record(draw: Random, asset_id: str) -> dict[str, Any]:
    """A record with values of every kind that the catalog holds, most of them from short lists so that they meet."""
    record = json.loads(SAMPLE.read_text()) | {"asset_id": asset_id}

    def sure() -> float:
        return draw.choice((0.0, 0.3, 0.5, 0.9, 1.0))

    record["outcome"] = draw.choice(("accepted", "repaired", "review"))
    category = draw.choice(CATEGORIES)
    semantics = record["semantics"]
    semantics["name"] = draw.choice(NAMES)
    semantics["category"] = evidence(category, 0.0 if category == "unknown" else draw.choice((0.4, 0.9)))
    semantics["family"] = evidence(FAMILIES.get(category, "unknown"), 0.5)
    semantics["hypotheses"] = [{"category": c, "score": draw.choice((0.2, 0.6)), "clues": []} for c in CATEGORIES[:2]]
    semantics["roles"] = [evidence(role, sure()) for role in draw.sample(ROLES, draw.randrange(3))]
    semantics["interaction_group"] = evidence(draw.choice(GROUPS), 0.7) if draw.random() < 0.5 else None
    record["physics"]["material"] = evidence(draw.choice(MATERIALS), sure())
    record["physics"]["mass_kg"] = evidence(draw.choice((0.05, 0.3, 2.0)), sure())
    record["physics"]["joints"] = [
        evidence({"name": f"j{k}", "type": draw.choice(JOINTS)}, 1.0) for k in range(draw.randrange(3))
    ]
    record["appearance"]["colours"] = {c: draw.choice((0.05, 0.2)) for c in draw.sample(COLOURS, draw.randrange(3))}
    edges = [draw.choice((0.05, 0.1, 0.3)) for _ in range(3)]
    record["geometry"]["extent_m"] = evidence(edges, sure())
    record["source"]["license"] = evidence(draw.choice(("CC0-1.0", "CC-BY-4.0", "unknown")), sure())
    kinds = draw.sample(("surface", "volume"), draw.randrange(3))
    record["anchors"] = [evidence(anchor(kind), sure()) for kind in kinds]
    record["affordances"] = [evidence(region(*draw.choice(TASKS)), sure()) for _ in range(draw.randrange(3))]
    if draw.random() < 0.7:
        record["geometry"]["shape"] = shape(draw)
    return record


def shape(draw: Random) -> dict[str, Any]:
    """A descriptor from a coarse grid with small offsets, so that equal, near and far ones occur."""
    first = draw.choice((0.5, 0.6)) + draw.choice((0.0, 0.01))
    step = draw.choice((0.1, 0.11))
    return {
        "scale_m": draw.choice((0.1, 0.2)),
        "second_moments": [first, 0.3, round(0.7 - first, 5)],
        "third_moments": [0.1, 0.05],
        "distances": [round(step * k, 5) for k in range(16)],
    }


def anchor(kind: str) -> dict[str, Any]:
    square = {"outline_m": [(0, 0), (1, 0), (1, 1), (0, 1)]}
    if kind == "surface":
        shown = {"polygon": square, "normal": (0, 0, 1), "area_m2": 1.0, "clearance_m": None, "load_directions": []}
        return {"kind": kind, "anchor_id": "top", "position_m": (0, 0, 0), **shown}
    figures = {"height_m": 0.1, "volume_m3": 3e-4, "passes_m": 0.05, "slices": []}
    place = {"position_m": (0, 0, 0), "opening": square, "direction": (0, 0, 1)}
    return {"kind": kind, "anchor_id": "inside", **place, **figures}


def region(kind: str, task: str, interaction: str) -> dict[str, Any]:
    place = {"position_m": (0, 0, 0), "direction": (0, 0, 1), "outline_m": [], "size_m": 0.01}
    return {"kind": kind, "affordance_id": kind, "task": task, "interaction": interaction, **place}


def write(out: Path, record: dict[str, Any]) -> None:
    """The package folder of a record, with nothing else in it."""
    folder = out / str(record["asset_id"])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "record.json").write_text(json.dumps(record))
