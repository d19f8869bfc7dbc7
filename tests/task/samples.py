"""Samples of every predicate: what fulfils it, what almost does, and what tries to deceive it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from schemas.task.state_log import StateLog
from tests.task.world import FRAMES, RATE_HZ, REST, logged, turned

Kind = Literal["true", "almost", "hostile"]
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
HELD = {"red": ("left", "right")}
TIPPED = turned(X, np.pi / 2.0)
DOWN = turned(X, np.pi)
BACK = turned(Z, np.pi)


@dataclass(frozen=True)
class Sample:
    """A predicate as written, a log, and whether it holds in the last frame: exactly for the kind "true"."""

    written: Mapping[str, Any]
    kind: Kind
    why: str
    log: StateLog

    @property
    def func(self) -> str:
        """The name of the predicate."""
        return self.written["_func"]


def steps(*levels: tuple[float, float]) -> np.ndarray:
    """(FRAMES,) a joint that has each position (second) from each stamp (first, s) on."""
    t_s, values = np.arange(FRAMES) / RATE_HZ, np.zeros(FRAMES)
    for begin, level in levels:
        values[t_s >= begin] = level
    return values


def moved(start: tuple[float, ...], end: tuple[float, ...], at: int = FRAMES // 2) -> np.ndarray:
    """(FRAMES, 3) on a straight way that takes the frames from `at` to 10 before the end."""
    share = np.clip((np.arange(FRAMES) - at) / (FRAMES - 10 - at), 0.0, 1.0)[:, None]
    return np.asarray(start)[None] * (1.0 - share) + np.asarray(end)[None] * share


def _samples() -> list[Sample]:
    rows: list[Sample] = []

    def of(written: Mapping[str, Any], *cases: tuple[Kind, str, StateLog]) -> None:
        rows.extend(Sample(written, kind, why, log) for kind, why, log in cases)

    of(
        {"_func": "inside", "object": "red", "container": "basket"},
        ("true", "on the floor", logged({"red": (0.3, 0.0, 0.025)}, touches={"red": ("basket",)})),
        ("true", "in a basket that is carried", logged({"red": (0.3, 0.0, 0.525), "basket": (0.3, 0.0, 0.52)})),
        ("almost", "on the rim", logged({"red": (0.41, 0.0, 0.06)}, touches={"red": ("basket",)})),
        ("almost", "over the opening", logged({"red": (0.3, 0.0, 0.14)})),
        ("hostile", "held inside", logged({"red": (0.3, 0.0, 0.03)}, touches=HELD)),
        (
            "hostile",
            "beside a basket that tipped over",
            logged({"red": (0.3, -0.06, 0.02), "basket": (0.3, 0.0, 0.12, *TIPPED)}),
        ),
        ("hostile", "under the table", logged({"red": (0.3, 0.0, -0.1)})),
    )
    of(
        {"_func": "on", "object": "red", "support": "blue"},
        ("true", "on top", logged({"red": (-0.3, 0.2, 0.06)}, touches={"red": ("blue",)})),
        ("true", "shifted", logged({"red": (-0.285, 0.2, 0.06)}, touches={"red": ("blue",)})),
        ("almost", "centre over the edge", logged({"red": (-0.275, 0.2, 0.06)}, touches={"red": ("blue",)})),
        ("hostile", "hovers by a millimetre", logged({"red": (-0.3, 0.2, 0.061)}, touches={"red": ()})),
        ("hostile", "held there", logged({"red": (-0.3, 0.2, 0.06)}, touches={"red": ("blue", "left", "right")})),
        ("hostile", "below it", logged({"blue": (-0.3, 0.0, 0.06)}, touches={"red": ("blue", "table")})),
    )
    of(
        {"_func": "near", "object": "red", "destination": "basket", "distance_m": 0.12},
        ("true", "beside it", logged({"red": (0.19, 0.0, 0.02)})),
        ("almost", "a little farther", logged({"red": (0.17, 0.0, 0.02)})),
        ("hostile", "held near it", logged({"red": (0.19, 0.0, 0.2)}, touches=HELD)),
    )
    of(
        {"_func": "beside", "object": "red", "reference": "blue", "side": "left"},
        ("true", "left of it", logged({"red": (-0.4, 0.2, 0.02)})),
        ("almost", "left, but behind", logged({"red": (-0.4, 0.35, 0.02)})),
        ("almost", "footprints overlap", logged({"red": (-0.33, 0.2, 0.06)})),
        ("hostile", "right of it", logged({"red": (-0.2, 0.2, 0.02)})),
        ("hostile", "held left of it", logged({"red": (-0.4, 0.2, 0.2)}, touches=HELD)),
    )
    of(
        {"_func": "beside", "object": "red", "reference": "blue", "side": "left", "frame": "base"},
        (
            "true",
            "the base looks along -x",
            logged({"red": (-0.2, 0.2, 0.02), "base": (1.0, 0.0, 0.0, *BACK)}),
        ),
        (
            "hostile",
            "left in the world",
            logged({"red": (-0.4, 0.2, 0.02), "base": (1.0, 0.0, 0.0, *BACK)}),
        ),
    )
    of(
        {"_func": "aligned", "objects": ["green", "red", "blue"], "axis": "y", "ordered": True},
        ("true", "in line", logged()),
        ("almost", "one sticks out", logged({"red": (-0.25, 0.0, 0.02)})),
        ("hostile", "in another order", logged({"red": (-0.3, 0.3, 0.02)})),
        ("hostile", "the last one is held", logged(touches=HELD)),
    )
    tower = {"blue": (-0.3, 0.0, 0.06), "green": (-0.3, 0.0, 0.1)}
    standing = {"blue": ("red",), "green": ("blue",)}
    of(
        {"_func": "stacked", "layers": ["red", "blue", "green"]},
        ("true", "a tower", logged(tower, touches=standing)),
        ("almost", "two layers", logged({"blue": (-0.3, 0.0, 0.06)}, touches={"blue": ("red",)})),
        ("almost", "leans too far", logged(tower | {"green": (-0.275, 0.0, 0.1)}, touches=standing)),
        ("hostile", "in another order", logged({"green": (-0.3, 0.0, 0.06), "blue": (-0.3, 0.0, 0.1)})),
        ("hostile", "the top is held", logged(tower, touches=standing | {"green": ("blue", "left", "right")})),
    )
    of(
        {"_func": "inserted", "object": "peg", "hole": "socket", "depth_m": 0.03},
        ("true", "to the ground", logged({"peg": (0.1, -0.2, 0.03)}, touches={"peg": ("socket",)})),
        ("almost", "not deep enough", logged({"peg": (0.1, -0.2, 0.06)}, touches={"peg": ("socket",)})),
        ("hostile", "beside the socket, as deep", logged({"peg": (0.15, -0.2, 0.02)})),
        ("hostile", "through its wall", logged({"peg": (0.115, -0.2, 0.03)})),
        ("hostile", "held in it", logged({"peg": (0.1, -0.2, 0.03)}, touches={"peg": ("socket", "left", "right")})),
    )
    of(
        {"_func": "hung", "object": "peg", "hook": "hook"},
        ("true", "hangs", logged({"peg": (0.5, 0.3, 0.22)}, touches={"peg": ("hook",)})),
        ("almost", "stands on the hook", logged({"peg": (0.5, 0.3, 0.32)}, touches={"peg": ("hook",)})),
        ("hostile", "leans on the hook", logged({"peg": (0.5, 0.3, 0.2)}, touches={"peg": ("hook", "table")})),
        ("hostile", "held at the hook", logged({"peg": (0.5, 0.3, 0.22)}, touches={"peg": ("hook", "left", "right")})),
        ("hostile", "floats under it", logged({"peg": (0.5, 0.3, 0.19)}, touches={"peg": ()})),
    )
    of(
        {"_func": "covered", "object": "red", "cup": "cup"},
        ("true", "under the cup", logged({"cup": (-0.3, 0.0, 0.12, *DOWN)})),
        ("almost", "beside the upturned cup", logged({"cup": (-0.2, 0.0, 0.12, *DOWN)})),
        ("hostile", "in an upright cup", logged({"red": (0.0, 0.2, 0.03)}, touches={"red": ("cup",)})),
        (
            "hostile",
            "the cup is held",
            logged({"cup": (-0.3, 0.0, 0.12, *DOWN)}, touches={"cup": ("left", "right")}),
        ),
    )
    region = [[-0.5, -0.1], [-0.1, -0.1], [-0.1, 0.1], [-0.5, 0.1]]
    of(
        {"_func": "clear_region", "support": "table", "objects": ["red", "blue"], "outline": region},
        ("true", "both elsewhere", logged({"red": (0.2, 0.2, 0.02)})),
        ("almost", "one corner inside", logged({"red": (-0.085, 0.0, 0.02)})),
        ("hostile", "one inside", logged()),
        ("hostile", "held over it", logged({"red": (-0.3, 0.0, 0.2)}, touches=HELD)),
    )
    of(
        {"_func": "upright", "object": "cup"},
        ("true", "turned about the vertical", logged({"cup": (0.0, 0.2, 0.02, *turned(Z, 2.0))})),
        ("almost", "leans by 16 degrees", logged({"cup": (0.0, 0.2, 0.02, *turned(X, np.deg2rad(16.0)))})),
        ("hostile", "upside down", logged({"cup": (0.0, 0.2, 0.12, *DOWN)})),
    )
    of(
        {"_func": "oriented", "object": "box", "toward": "base"},
        ("true", "faces the base", logged({"box": (-0.5, 0.3, 0.02, *turned(Z, np.arctan2(-0.3, -0.2)))})),
        ("almost", "20 degrees off", logged({"box": (-0.5, 0.3, 0.02, *turned(Z, np.arctan2(-0.3, -0.2) + 0.35))})),
        ("hostile", "faces away", logged({"box": (-0.5, 0.3, 0.02, *turned(Z, np.arctan2(0.3, 0.2)))})),
    )
    of(
        {"_func": "oriented", "object": "box", "direction": [0.0, 1.0, 0.0], "either_way": True},
        ("true", "along -y", logged({"box": (-0.5, 0.3, 0.02, *turned(Z, -np.pi / 2.0))})),
        ("hostile", "along x", logged()),
    )
    away = moved(tuple(REST["red"]), (-0.2, 0.0, 0.02))
    of(
        {"_func": "undisturbed", "objects": ["red", "blue"]},
        ("true", "nothing moved", logged()),
        ("almost", "3 cm away", logged(motion={"red": moved(tuple(REST["red"]), (-0.27, 0.0, 0.02))})),
        ("hostile", "both moved", logged(motion={"red": away, "blue": moved(tuple(REST["blue"]), (-0.3, 0.3, 0.02))})),
    )
    of(
        {"_func": "home"},
        ("true", "at home", logged(joints={"arm/j1": 0.55})),
        ("almost", "one joint off", logged(joints={"arm/j2": -0.85})),
        ("hostile", "a turn away", logged(joints={"arm/j1": 0.5 + 2.0 * np.pi})),
    )
    of(
        {"_func": "base_near", "base": "base", "object": "red", "distance_m": 0.5, "facing": 0.5},
        ("true", "near and facing", logged()),
        ("almost", "too far", logged({"base": (-0.85, 0.0, 0.0)})),
        ("hostile", "near, its back to it", logged({"base": (-0.7, 0.0, 0.0, *BACK)})),
    )
    t = np.arange(FRAMES) / RATE_HZ
    of(
        {"_func": "dwell", "of": {"_func": "balanced", "joint": "scale/beam"}, "for_s": 1.0},
        ("true", "comes to rest", logged(joints={"scale/beam": np.maximum(0.5 - t, 0.0)})),
        ("almost", "level for half a second", logged(joints={"scale/beam": np.maximum(2.5 - t, 0.0)})),
        ("hostile", "swings through level", logged(joints={"scale/beam": 0.3 * np.sin(6.0 * t)})),
    )
    of(
        {"_func": "balanced", "joint": "scale/beam"},
        ("true", "level", logged(joints={"scale/beam": 0.02})),
        ("almost", "3 degrees", logged(joints={"scale/beam": np.deg2rad(3.0)})),
        ("hostile", "turned over", logged(joints={"scale/beam": np.pi})),
    )
    of(
        {"_func": "joint_at", "joint": "drawer/slide", "at_least": 0.15},
        ("true", "open", logged(joints={"drawer/slide": 0.16})),
        ("almost", "a centimetre short", logged(joints={"drawer/slide": 0.14})),
        ("hostile", "opened and shut again", logged(joints={"drawer/slide": steps((0.5, 0.2), (2.0, 0.0))})),
    )
    of(
        {"_func": "joint_turned", "joint": "nut/turn", "turns": 1.0},
        (
            "true",
            "wraps at pi",
            logged(joints={"nut/turn": (np.linspace(0.0, 7.0, FRAMES) + np.pi) % (2 * np.pi) - np.pi}),
        ),
        ("almost", "most of a turn", logged(joints={"nut/turn": np.linspace(0.0, 6.0, FRAMES)})),
        ("hostile", "to and fro", logged(joints={"nut/turn": 1.5 * np.sin(6.0 * t)})),
        ("hostile", "the other way", logged(joints={"nut/turn": np.linspace(0.0, -7.0, FRAMES)})),
    )
    press = {"_func": "pressed", "joint": "button/press", "press_at": 0.008, "release_at": 0.002}
    twice = steps((0.2, 0.01), (0.4, 0.0), (0.8, 0.01), (1.0, 0.0))
    of(
        {**press, "times": 2, "settle_s": 1.0},
        ("true", "two presses", logged(joints={"button/press": twice})),
        ("almost", "one press", logged(joints={"button/press": steps((0.2, 0.01), (0.4, 0.0))})),
        ("hostile", "one too many", logged(joints={"button/press": twice + steps((2.4, 0.01), (2.6, 0.0))})),
        ("hostile", "chatters at the threshold", logged(joints={"button/press": 0.008 + 0.0005 * np.sin(90.0 * t)})),
        ("hostile", "touched, not pressed", logged(joints={"button/press": 0.5 * twice})),
        ("hostile", "down from the start", logged(joints={"button/press": 0.01})),
    )
    lifted = {"red": (-0.3, 0.0, 0.2)}
    of(
        {"_func": "raised", "object": "red", "over": "table", "height_m": 0.05},
        ("true", "lifted", logged(lifted, touches=HELD)),
        ("almost", "4 cm", logged({"red": (-0.3, 0.0, 0.06)})),
        ("hostile", "lifted with one edge down", logged({"red": (-0.3, 0.0, 0.07, *turned(X, 0.8))})),
        ("hostile", "below the table", logged({"red": (-0.3, 0.0, -0.2)})),
    )
    of(
        {"_func": "held_by", "object": "red"},
        ("true", "lifted", logged(lifted, touches=HELD)),
        ("almost", "grasped, still on the table", logged(touches={"red": ("left", "right", "table")})),
        ("hostile", "touched by one finger", logged(lifted, touches={"red": ("left",)})),
        ("hostile", "carried on another block", logged(lifted, touches={"red": ("left", "right", "blue")})),
        ("hostile", "floats", logged(lifted, touches={"red": ()})),
    )
    of(
        {"_func": "released", "object": "red", "retreat_m": 0.1},
        ("true", "the hand is away", logged()),
        ("almost", "the hand is still near", logged({"palm": (-0.3, 0.0, 0.1)})),
        ("hostile", "one finger touches", logged(touches={"red": ("left", "table")})),
    )
    into = {"_func": "inside", "object": "$member", "container": "basket"}
    three = {name: (0.3, y, 0.025) for name, y in (("red", -0.05), ("blue", 0.0), ("green", 0.05))}
    two = {name: three[name] for name in ("red", "blue")}
    of(
        {"_func": "counted", "members": ["red", "blue", "green"], "where": into, "exactly": 2},
        ("true", "two", logged(two)),
        ("almost", "one", logged({"red": three["red"]})),
        ("hostile", "one too many", logged(three)),
    )
    of(
        {"_func": "all_and_only", "members": ["red", "blue"], "others": ["red", "blue", "green"], "where": into},
        ("true", "these two", logged(two)),
        ("almost", "one of them", logged({"red": three["red"]})),
        ("hostile", "a third one too", logged(three)),
    )
    down = {"_func": "joint_at", "joint": "button/press", "at_least": 0.008}
    ring = {"_func": "joint_at", "joint": "bell/press", "at_least": 0.008}
    first, second = steps((0.2, 0.01), (0.4, 0.0)), steps((1.0, 0.01), (1.2, 0.0))
    of(
        {"_func": "sequence", "steps": [down, ring, down], "on_mistake": "spoil"},
        ("true", "in order", logged(joints={"button/press": first + steps((2.0, 0.01)), "bell/press": second})),
        ("almost", "the last is missing", logged(joints={"button/press": first, "bell/press": second})),
        ("hostile", "in another order", logged(joints={"button/press": second, "bell/press": first})),
        ("hostile", "one twice", logged(joints={"button/press": twice, "bell/press": steps((1.5, 0.01), (1.7, 0.0))})),
        ("hostile", "both at once", logged(joints={"button/press": first + second, "bell/press": first})),
    )
    of(
        {"_func": "matches_attribute", "object": "red", "attribute": "colour", "equals": "red"},
        ("true", "red", logged()),
    )
    of(
        {"_func": "matches_attribute", "object": "red", "attribute": "colour", "like": "blue"},
        ("almost", "another colour", logged()),
    )
    of(
        {"_func": "matches_attribute", "object": "red", "attribute": "shape", "equals": "Cube"},
        ("hostile", "another word", logged()),
    )
    inside, gone = {"_func": "inside", "object": "red", "container": "basket"}, {"_func": "released", "object": "red"}
    held_there = logged(two, touches=HELD)
    of(
        {"_func": "all_of", "of": [inside, gone]},
        ("true", "both", logged(two)),
        ("almost", "one", logged(two, touches={"red": ("left", "basket")})),
        ("hostile", "none", held_there),
    )
    of(
        {"_func": "any_of", "of": [inside, {**inside, "object": "blue"}]},
        ("true", "one", logged({"blue": three["blue"]})),
        ("almost", "on the rim", logged({"blue": (0.41, 0.0, 0.06)})),
        ("hostile", "held there", logged({"red": three["red"]}, touches=HELD)),
    )
    of(
        {"_func": "negation", "of": inside},
        ("true", "outside", logged()),
        ("almost", "barely inside", logged({"red": (0.36, 0.0, 0.025)})),
        ("hostile", "inside", logged(two)),
    )
    return rows


SAMPLES = tuple(_samples())
