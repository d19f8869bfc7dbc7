"""Lists every asset, every yaw and every placement of a program, each with its path."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from schemas.scene.placing import DiscretePlacement, Group, Placement, Pose, Ranges, Slot, SlotGroup
from schemas.scene.program import Asset, Background, SceneProgram
from source.tree import Path

WithYaw: TypeAlias = Background | Ranges | Pose | Slot


class WrittenAsset(NamedTuple):
    """An asset with its path in the program, and the scale and role of the object that uses it."""

    path: Path
    asset: Asset | str
    scale: float
    role: str | None
    background: bool


def written_assets(program: SceneProgram) -> Iterator[WrittenAsset]:
    """Assets of objects, backgrounds and their variants; one for an object that is not declared has scale 1."""
    for i, thing in enumerate(program.objects):
        yield WrittenAsset(("objects", i, "asset"), thing.asset, thing.scale, thing.role, False)
    if (ground := program.background) is not None:
        yield WrittenAsset(("background", "asset"), ground.asset, ground.scale, None, True)
    objects = {thing.id: thing for thing in program.objects}
    for i, variant in enumerate(program.variants.assets):
        for name, asset in variant.objects.items():
            path, thing = ("variants", "assets", i, "objects", name), objects.get(name)
            scale, role = (1.0, None) if thing is None else (thing.scale, thing.role)
            yield WrittenAsset(path, asset, scale, role, False)
    for i, variant in enumerate(program.variants.backgrounds):
        path, ground = ("variants", "backgrounds", i, "background", "asset"), variant.background
        yield WrittenAsset(path, ground.asset, ground.scale, None, True)


def written_yaws(program: SceneProgram) -> Iterator[tuple[Path, WithYaw]]:
    """All items with a yaw: backgrounds, ranges (also of keep-outs), poses, slots."""
    if program.background is not None:
        yield ("background",), program.background
    for i, variant in enumerate(program.variants.backgrounds):
        yield ("variants", "backgrounds", i, "background"), variant.background
    for path, placing in written_placings(program):
        if isinstance(placing, SlotGroup):
            yield from (((*path, "slots", i), slot) for i, slot in enumerate(placing.slots))
        elif isinstance(placing, DiscretePlacement):
            yield from (((*path, "poses", i), pose) for i, pose in enumerate(placing.poses))
        else:
            yield (*path, "ranges"), placing.ranges
    for i, keep_out in enumerate(program.keep_outs):
        if keep_out.ranges is not None:
            yield ("keep_outs", i, "ranges"), keep_out.ranges


def written_placings(program: SceneProgram) -> Iterator[tuple[Path, Placement | Group]]:
    """Placements of nodes, then groups."""
    for name, node in program.layout.nodes.items():
        if node.placement is not None:
            yield ("layout", "nodes", name, "placement"), node.placement
    for name, group in program.layout.groups.items():
        yield ("layout", "groups", name), group
