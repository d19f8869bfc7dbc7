"""Valid pipelines, from a seed: scenes, robots, tasks of several stages, assemblies, rollouts, a key on each line."""

from __future__ import annotations

import random

_CONDITIONS = (
    ("upright", ("object: '@goods'", "tilt: 0.3")),
    ("inside", ("object: '@goods'", "container: cabinet", "least_share: 0.6")),
    ("on", ("object: '@goods'", "support: '@target'", "gap_m: 0.02", "overlap: 0.5")),
    ("near", ("object: '@goods'", "destination: '@target'", "distance_m: 0.2")),
    ("released", ("object: '@goods'", "retreat_m: 0.1")),
    ("held_by", ("object: '@goods'", "off_support: true")),
    ("joint_at", ("joint: cabinet/drawer", "at_least: 0.1", "at_most: 0.4")),
    ("pressed", ("joint: button/press", "press_at: 0.008", "release_at: 0.002", "times: 2")),
)


def program(seed: int) -> str:
    """The text of a pipeline without a fault."""
    rng = random.Random(seed)
    scenes, tasks = rng.randint(1, 2), rng.randint(1, 2)
    lines = ["scene_factory:", "  type: default_scene_factory", "scene_orders:"]
    for k in range(scenes):
        lines += _scene(f"scene{k}", rng)
    lines += ["robot_orders:"]
    lines += ["  - name: arm", "    gripper_variant: G", "    kinematics: panda"]
    lines += ["task_orders:"]
    for k in range(tasks):
        lines += _task(f"task{k}", rng)
    lines += ["assembly_orders:"]
    names = []
    for k in range(max(scenes, tasks)):
        names.append(f"env{k}")
        lines += ["  - assembly_generator:", f"      name: env{k}", f"      scene_generator_name: scene{k % scenes}"]
        lines += ["      robot_generator_name: arm", f"      task_generator_name: task{k % tasks}"]
    lines += ["rollout:"]
    for k, name in enumerate(names):
        lines += [f"  - env_ref: {name}", "    modes: [gendata]" if k else "    modes: [gendata, benchmark]"]
        lines += ["    teacher:", "      type: teleop", "      device: keyboard"]
    return "\n".join([*lines, ""])


def _scene(name: str, rng: random.Random) -> list[str]:
    things = [("goods1", "[goods]"), ("target1", "[target]")]
    things += [(f"other{k}", "[clutter]") for k in range(rng.randint(1, 3))]
    lines = [
        f"  - scene: {name}",
        "    background:",
        "      asset:",
        "        type: box",
        "        size_m: [1.6, 1.2, 0.05]",
    ]
    lines += ["    objects:"]
    for thing, tags in things:
        lines += [f"      - id: {thing}", "        asset:", "          type: cylinder", "          radius_m: 0.04"]
        lines += ["          height_m: 0.1", f"        semantic_tags: {tags}"]
    for thing in ("cabinet", "button"):
        lines += [f"      - id: {thing}", f"        asset: {thing}_a"]
        things.append((thing, ""))
    lines += ["    anchors:", "      top:", "        object: background", "        surface: auto"]
    lines += ["    layout:", "      nodes:"]
    for thing, _ in things:
        lines += [f"        {thing}:", f"          object: {thing}", "          placement:"]
        lines += ["            type: surface", "            surface: top"]
    lines += ["    relations:", "      - left_of: [goods1, target1]", "        gap: 0.05", "    clearance: 0.01"]
    return lines


def _task(name: str, rng: random.Random) -> list[str]:
    count = rng.randint(2, 4)
    shares = [10 // count] * count
    shares[0] += 10 - sum(shares)
    lines = [
        f"  - task: {name}",
        "    instruction: do it",
        "    time_limit_s: 60",
        "    graph_task_generator:",
        "      nodes:",
    ]
    for k, points in enumerate(shares):
        func, parameters = rng.choice(_CONDITIONS)
        lines += [f"        - id: stage{k}", f"          score: {points}", "          timeout_s: 30"]
        lines += ["          true_at_reset: true", "          success:", f"            _func: {func}"]
        lines += [f"            {each}" for each in parameters]
    lines += ["      edges:"]
    for k in range(count - 1):
        lines += [f"        - src: stage{k}", f"          dst: stage{k + 1}"]
    return lines
