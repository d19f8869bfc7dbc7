"""Look-ups by name in a program: nodes and their copies, groups, owners of anchors."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

from schemas.scene.geometry import BACKGROUND
from schemas.scene.placing import (
    DiscretePlacement,
    GridGroup,
    Group,
    Placement,
    ScatterGroup,
    SlotGroup,
    StackGroup,
    VolumeGroup,
    VolumePlacement,
)
from schemas.scene.program import SceneProgram

MAX_THINGS = 2000
WORLD = "world"


class Names:
    """Look-ups over a program whose keys and values are valid; names need not be."""

    def __init__(self, program: SceneProgram) -> None:
        self.program = program

    @cached_property
    def objects(self) -> dict[str, int]:
        """Index of each object by id."""
        return {o.id: i for i, o in enumerate(self.program.objects)}

    @cached_property
    def groups_of(self) -> dict[str, tuple[str, ...]]:
        """The groups that each node is a member of."""
        group_names: dict[str, tuple[str, ...]] = {}
        for name, group in self.program.layout.groups.items():
            for member in dict.fromkeys(group.members):
                group_names[member] = (*group_names.get(member, ()), name)
        return group_names

    @cached_property
    def copies(self) -> dict[str, tuple[str, ...]]:
        """The placed things of each node: itself, or `name-1 ... name-count` in a scatter group with a count."""
        return {node: self._copies(node) for node in self.program.layout.nodes}

    @cached_property
    def things(self) -> frozenset[str]:
        """All placed things."""
        return frozenset(thing for copies in self.copies.values() for thing in copies)

    def count(self) -> int:
        """How many things are placed, without listing them."""
        return sum(self._count(node) for node in self.program.layout.nodes)

    def things_named(self, name: str) -> tuple[str, ...]:
        """The things that a name in a relation or a list of members refers to; none when it is unknown."""
        if name in self.copies:
            return self.copies[name]
        group = self.program.layout.groups.get(name)
        if group is not None:
            return tuple(t for member in dict.fromkeys(group.members) for t in self.copies.get(member, ()))
        return (name,) if name in self.things else self._lines.get(name, ())

    def part_of(self, name: str) -> tuple[str, str] | None:
        """Name and part of `mug.handle`, where the first is known and the whole is not; None for other names."""
        base, dot, part = name.partition(".")
        if not dot or not part or self.things_named(name) or not self.things_named(base):
            return None
        return base, part

    @property
    def named_by_parts(self) -> frozenset[str]:
        """Ids of the objects of which a relation names a part."""
        written = (name for r in self.program.relations for row in r.words for name in r.members(row)[:1])
        parts = (part for name in written if (part := self.part_of(name)) is not None)
        return frozenset(self.object_of(thing) for base, _ in parts for thing in self.things_named(base))

    @cached_property
    def _lines(self) -> dict[str, tuple[str, ...]]:
        # The things of each row and column of each grid: `rack.front`.
        lines: dict[str, tuple[str, ...]] = {}
        for name, group in self.grids.items():
            things = dict(zip(group.cells(), self.things_named(name), strict=False))
            for r, row in enumerate(group.row_names):
                lines[f"{name}.{row}"] = tuple(thing for (at, _), thing in things.items() if at == r)
            for c, column in enumerate(group.column_names):
                lines[f"{name}.{column}"] = tuple(thing for (_, at), thing in things.items() if at == c)
        return lines

    @cached_property
    def grids(self) -> dict[str, GridGroup]:
        """The grids by name. Each is also a thing of the problem: the frame in which its members have fixed poses."""
        return {name: group for name, group in self.program.layout.groups.items() if isinstance(group, GridGroup)}

    @property
    def lines(self) -> tuple[str, ...]:
        """Names of the rows and columns of grids, with that of their grid before a dot."""
        return tuple(self._lines)

    def placed(self, name: str) -> tuple[str, ...]:
        """The things that an anchor's `object` may refer to: those of the node, else of all nodes of the object."""
        if name == BACKGROUND:
            return (BACKGROUND,)
        if name in self.copies:
            return self.copies[name]
        nodes = [node for node, written in self.program.layout.nodes.items() if written.object == name]
        return tuple(t for node in nodes for t in self.copies[node]) or ((name,) if name in self.things else ())

    @cached_property
    def node_of(self) -> dict[str, str]:
        """The node of each placed thing."""
        return {thing: node for node, copies in self.copies.items() for thing in copies}

    def object_of(self, name: str) -> str:
        """The id of the object that `name`, a node, an object or a copy, refers to; itself where it is unknown."""
        if name not in self.copies and name in self.objects:
            return name
        node = self.node_of.get(name, name)
        return self.program.layout.nodes[node].object if node in self.copies else name

    def owner(self, anchor: str) -> str | None:
        """The one thing, or `background`, that an anchor belongs to; None when there is not exactly one."""
        return self._owners.get(anchor)

    @cached_property
    def _owners(self) -> dict[str, str]:
        placed = {anchor: self.placed(reference.object) for anchor, reference in self.program.anchors.items()}
        return {anchor: things[0] for anchor, things in placed.items() if len(things) == 1}

    def stacked(self, group: str) -> tuple[str, ...]:
        """The things of a stack from the lowest to the highest."""
        return self.things_named(group) if isinstance(self.program.layout.groups[group], StackGroup) else ()

    def placing(self, node: str) -> Placement | Group | None:
        """What places a node: its own placement, or the group that owns it."""
        groups = self.groups_of.get(node, ())
        return self.program.layout.nodes[node].placement or (self.program.layout.groups[groups[0]] if groups else None)

    def anchor_of(self, node: str) -> str | None:
        """The anchor on which a node is placed."""
        placing = self.placing(node)
        return anchor_named(placing) if placing is not None else None

    def _count(self, node: str) -> int:
        if node not in self.groups_of:
            return 1
        if (grid := self._grid_of_copies(node)) is not None:
            return len(grid.row_names) * len(grid.column_names)
        groups = (self.program.layout.groups[name] for name in self.groups_of[node])
        return max((group.count for group in groups if isinstance(group, ScatterGroup | StackGroup)), default=1)

    def _grid_of_copies(self, node: str) -> GridGroup | None:
        # The grid whose cells all hold copies of a node.
        groups = (self.grids.get(name) for name in self.groups_of.get(node, ()))
        return next((grid for grid in groups if grid is not None and len(grid.members) == 1), None)

    def _copies(self, node: str) -> tuple[str, ...]:
        count = self._count(node)
        if count > 1 and (grid := self._grid_of_copies(node)) is not None:
            rows = grid.row_names if not isinstance(grid.rows, int) else tuple(map(str, range(1, grid.rows + 1)))
            columns = grid.column_names
            if isinstance(grid.columns, int):
                columns = tuple(map(str, range(1, grid.columns + 1)))
            return tuple(f"{node}-{rows[r]}-{columns[c]}" for r, c in grid.cells())
        return (node,) if count == 1 else tuple(f"{node}-{i}" for i in range(1, count + 1))


def anchor_named(placing: Placement | Group) -> str:
    """The anchor that a placement or group names, empty where it names none."""
    if isinstance(placing, DiscretePlacement | SlotGroup):
        return placing.surface or placing.volume or ""
    return placing.volume if isinstance(placing, VolumePlacement | VolumeGroup) else placing.surface


def kind_of(placing: Placement | Group) -> Literal["surface", "volume"]:
    """Whether it places on a surface or in a volume."""
    if isinstance(placing, DiscretePlacement | SlotGroup):
        return "surface" if placing.surface is not None else "volume"
    return "volume" if isinstance(placing, VolumePlacement | VolumeGroup) else "surface"


def upright(placing: Placement | Group | None) -> bool:
    """Whether the placed things can only turn about the vertical."""
    if isinstance(placing, DiscretePlacement):
        quats = [pose.quat_wxyz for pose in placing.poses if pose.quat_wxyz is not None]
    elif placing is None or isinstance(placing, SlotGroup | StackGroup | GridGroup) or placing.orientation == "upright":
        return True
    elif placing.orientation == "stable":
        return False
    else:
        quats = list(placing.orientation)
    return all(abs(x) < 1e-6 and abs(y) < 1e-6 for _, x, y, _ in quats)
