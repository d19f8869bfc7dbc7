"""Blocks: coloured cubes or bricks, each an object of its own."""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.generate.generator import PAINTS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, count, quantity
from assetkit.generate.shape import box


@dataclass(frozen=True)
class Blocks:
    """Parameters of `blocks`."""

    blocks: int = count(4, 1, 11, "blocks, each of another colour")
    edge_m: float = quantity(0.04, 0.02, 0.08, "m", "edge of a cube; width and height of a brick")
    length: float = quantity(1.0, 1.0, 3.0, "", "length of a block, of its edge")
    material: str = choice("wood", ("wood", "plastic", "foam"), "material of the blocks")


def build(p: Blocks) -> GeneratedSet:
    """The blocks, in the order of the colours."""
    half, long = 0.5 * p.edge_m, 0.5 * p.edge_m * p.length
    shape = box((-half, -long, 0.0), (half, long, p.edge_m))
    links = [GeneratedLink("body", (GeneratedPart("body", shape, p.material, c),)) for c in PAINTS[: p.blocks]]
    return GeneratedSet(tuple(GeneratedObject(f"{c}_block", (link,)) for c, link in zip(PAINTS, links, strict=False)))


GENERATOR = Generator("blocks", "Coloured blocks", Blocks, build)
