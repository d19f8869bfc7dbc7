"""Kinds of mistakes: each finds the lines of a pipeline that it can spoil, and gives the spoiled text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple


class Fault(NamedTuple):
    """A spoiled text, and the line (from 1) at which a reader should be shown the mistake."""

    text: str
    line: int


Inject = Callable[[list[str]], Iterator[Fault]]
_KEYS = (
    *("scene_orders", "robot_orders", "task_orders", "assembly_orders", "rollout", "background", "objects", "anchors"),
    *("layout", "relations", "clearance", "asset", "semantic_tags", "radius_m", "height_m", "size_m", "placement"),
    *("surface", "gap", "graph_task_generator", "edges", "score", "timeout_s", "true_at_reset", "success"),
    *("assembly_generator", "scene_generator_name", "robot_generator_name", "task_generator_name", "env_ref", "modes"),
    *("teacher", "instruction", "time_limit_s", "src", "dst"),
)
# A misspelt section or key that is needed may be shown where it is missing as well as where it stands.
_VALUES: tuple[tuple[str, str, str], ...] = (
    ("timeout that is negative", r"timeout_s: 30", "timeout_s: -30"),
    ("timeout that is a word", r"timeout_s: 30", "timeout_s: soon"),
    ("time limit that is zero", r"time_limit_s: 60", "time_limit_s: 0"),
    ("score that is negative", r"score: \d+", "score: -2"),
    ("score that is a word", r"score: \d+", "score: many"),
    ("flag that is a number", r"true_at_reset: true", "true_at_reset: 1"),
    ("degrees as radians", r"tilt: 0.3", "tilt: 17"),
    ("angle that is negative", r"tilt: 0.3", "tilt: -0.3"),
    ("share above one", r"least_share: 0.6", "least_share: 60"),
    ("overlap above one", r"overlap: 0.5", "overlap: 50"),
    ("length that is negative", r"distance_m: 0.2", "distance_m: -0.2"),
    ("length that is a word", r"retreat_m: 0.1", "retreat_m: far"),
    ("count that is a fraction", r"times: 2", "times: 2.5"),
    ("count of none", r"times: 2", "times: 0"),
    ("unknown predicate", r"_func: (\w+)", r"_func: \1_it"),
    ("mode that does not exist", r"modes: \[gendata", "modes: [gendatta"),
    ("modes that are no list", r"modes: \[.*\]", "modes: gendata"),
    ("unknown scene", r"scene_generator_name: scene0", "scene_generator_name: scene7"),
    ("unknown robot", r"robot_generator_name: arm", "robot_generator_name: leg"),
    ("unknown task", r"task_generator_name: task0", "task_generator_name: task7"),
    ("unknown assembly", r"env_ref: env0", "env_ref: env7"),
    ("edge from nowhere", r"src: stage0", "src: stage9"),
    ("edge to nowhere", r"dst: stage1", "dst: stage9"),
    ("edge to itself", r"dst: stage1", "dst: stage0"),
    ("unknown object of a node", r"object: goods1", "object: goods7"),
    ("unknown owner of an anchor", r"object: background", "object: foreground"),
    ("unknown anchor", r"surface: top", "surface: tops"),
    ("unknown member of a relation", r"left_of: \[goods1, target1\]", "left_of: [goods1, target7]"),
    ("relation with itself", r"left_of: \[goods1, target1\]", "left_of: [goods1, goods1]"),
    ("radius of zero", r"radius_m: 0.04", "radius_m: 0"),
    ("clearance that is negative", r"clearance: 0.01", "clearance: -0.01"),
    ("unknown kind of asset", r"type: cylinder", "type: cylindre"),
    ("tags that are no list", r"semantic_tags: \[clutter\]", "semantic_tags: 7"),
    ("tab for spaces", r"^( +)instruction: do it", "\tinstruction: do it"),
    ("bracket that stays open", r"modes: \[(.*)\]", r"modes: [\1"),
)


def kinds() -> dict[str, Inject]:
    """All kinds of mistakes by name."""
    table: dict[str, Inject] = {f"misspelt key {key}": _misspelt(key) for key in _KEYS}
    table |= {name: _replaced(pattern, with_) for name, pattern, with_ in _VALUES}
    table |= {
        "node twice": _renamed_id,
        "scene twice": _same_scene,
        "key twice": _same_key,
        "edge that closes a circle": _closing_edge,
        "condition without a name": _dropped(r"_func: \w+", 0),
        "node without a condition": _condition_dropped,
        "rollout without an environment": _replaced(r"- env_ref: env0", "- name: r0"),
        "include of an absent file": _replaced(r"kinematics: panda", "include: robot/absent.yaml"),
        "role that no object plays": _replaced(r"semantic_tags: \[goods\]", "semantic_tags: [good]"),
        "parts below what is made from them": _parts_last,
    }
    return table


def _spoiled(lines: list[str], number: int, text: str | None, shown: int | None = None) -> Fault:
    changed = [*lines[:number], *([] if text is None else [text]), *lines[number + 1 :]]
    return Fault("\n".join(changed), (number if shown is None else shown) + 1)


def _misspelt(key: str) -> Inject:
    def inject(lines: list[str]) -> Iterator[Fault]:
        for number, line in enumerate(lines):
            if re.match(rf"^[ -]*{key}:", line):
                yield _spoiled(lines, number, line.replace(f"{key}:", f"{key[:2]}{key[1:]}:", 1))

    return inject


def _replaced(pattern: str, with_: str) -> Inject:
    def inject(lines: list[str]) -> Iterator[Fault]:
        for number, line in enumerate(lines):
            if re.search(pattern, line):
                yield _spoiled(lines, number, re.sub(pattern, with_, line, count=1))

    return inject


def _dropped(pattern: str, shown: int) -> Inject:
    """The line is taken away; the mistake is shown at a line relative to it."""

    def inject(lines: list[str]) -> Iterator[Fault]:
        for number, line in enumerate(lines):
            if re.search(pattern, line):
                yield _spoiled(lines, number, None, number + shown)

    return inject


def _condition_dropped(lines: list[str]) -> Iterator[Fault]:
    """A whole `success` block; shown at the node."""
    for number, line in enumerate(lines):
        if line.strip() == "success:":
            depth = len(line) - len(line.lstrip())
            end = number + 1
            while len(lines[end]) - len(lines[end].lstrip()) > depth:
                end += 1
            node = max(k for k in range(number) if lines[k].lstrip().startswith("- id: stage"))
            yield Fault("\n".join([*lines[:number], *lines[end:]]), node + 1)


def _renamed_id(lines: list[str]) -> Iterator[Fault]:
    for number, line in enumerate(lines):
        if line.strip() == "- id: stage1":
            yield _spoiled(lines, number, line.replace("stage1", "stage0"))


def _same_scene(lines: list[str]) -> Iterator[Fault]:
    for number, line in enumerate(lines):
        if line.strip() == "- scene: scene1":
            yield _spoiled(lines, number, line.replace("scene1", "scene0"))


def _same_key(lines: list[str]) -> Iterator[Fault]:
    for number, line in enumerate(lines):
        if line.strip() == "score: 3" or line.strip().startswith("time_limit_s"):
            yield Fault("\n".join([*lines[: number + 1], line, *lines[number + 1 :]]), number + 2)


def _closing_edge(lines: list[str]) -> Iterator[Fault]:
    for number, line in enumerate(lines):
        if line.strip() == "dst: stage1":
            indent = " " * (len(line) - len(line.lstrip()) - 2)
            more = [f"{indent}- src: stage1", f"{indent}  dst: stage0"]
            yield Fault("\n".join([*lines[: number + 1], *more, *lines[number + 1 :]]), number + 2)


def _parts_last(lines: list[str]) -> Iterator[Fault]:
    begin = lines.index("robot_orders:")
    end = lines.index("task_orders:")
    moved = [*lines[:begin], *lines[end:-1], *lines[begin:end], ""]
    yield Fault("\n".join(moved), moved.index("robot_orders:") + 1)
