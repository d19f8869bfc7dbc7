"""The smallest pipeline for every `pipeline/` code: one sound pipeline with one thing changed."""

from __future__ import annotations

from pathlib import Path

SOUND = """\
scene_orders:
  - scene: desk
    background: {asset: {type: box, size_m: [1.2, 0.8, 0.05]}}
    objects:
      - {id: cup, asset: {type: cylinder, radius_m: 0.04, height_m: 0.1}, semantic_tags: [pickable]}
      - {id: can, asset: {type: cylinder, radius_m: 0.03, height_m: 0.1}, semantic_tags: [other]}
    anchors: {top: {object: background, surface: auto}}
    layout:
      nodes:
        cup: {object: cup, placement: {type: surface, surface: top}}
        can: {object: can, placement: {type: surface, surface: top}}
robot_orders:
  - {name: arm, kinematics: panda}
task_orders:
  - task: stand
    graph_task_generator:
      nodes: [{id: stand, score: 10, success: {_func: upright, object: '@pickable'}}]
assembly_orders:
  - assembly_generator:
      name: env
      scene_generator_name: desk
      robot_generator_name: arm
      task_generator_name: stand
rollout:
  - {env_ref: env, modes: [gendata], teacher: {type: teleop}}
"""
_ROBOTS = "robot_orders:\n  - {name: arm, kinematics: panda}\n"
CHANGES: dict[str, tuple[str, str]] = {
    "pipeline/unknown-key": ("robot_orders:", "robot_order: []\nrobot_orders:"),
    "pipeline/missing-key": ("{env_ref: env, modes", "{modes"),
    "pipeline/invalid-value": ("modes: [gendata]", "modes: [gendatta]"),
    "pipeline/illegal-order": (_ROBOTS, ""),
    "pipeline/name-twice": ("kinematics: panda}\n", "kinematics: panda}\n  - {name: arm}\n"),
    "pipeline/unnamed-order": ("kinematics: panda}\n", "kinematics: panda}\n  - {kinematics: other}\n"),
    "pipeline/unknown-name": ("env_ref: env", "env_ref: environment"),
    "pipeline/unbound-role": ("'@pickable'", "'@pickables'"),
    "pipeline/ambiguous-role": ("semantic_tags: [other]", "semantic_tags: [pickable]"),
    "pipeline/unmet-need": ("_func: upright,", "_func: inside, container: can,"),
    "pipeline/unused-order": ("kinematics: panda}\n", "kinematics: panda}\n  - {name: spare}\n"),
}


def sample(code: str) -> str:
    """The pipeline that a code is about."""
    old, new = CHANGES[code]
    assert SOUND.count(old) == 1
    text = SOUND.replace(old, new)
    return text + _ROBOTS if code == "pipeline/illegal-order" else text


def write(text: str, folder: Path) -> Path:
    """The file of a pipeline."""
    path = folder / "pipeline.yaml"
    path.write_text(text)
    return path
