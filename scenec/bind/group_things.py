"""Things of groups that a program places together: members of stacks on one another, of grids on their frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from scenec.bind.grid_frames import with_frame
from scenec.bind.stack_levels import most_off_balance_m, stack_level
from scenec.ir.names import Names
from scenec.ir.problem import Thing
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.geometry import ScenePlace
from schemas.scene.placing import StackGroup
from source.tree import Path


@dataclass(frozen=True)
class GroupThings:
    """Groups of a program. `top` gives the highest surface of a thing, None where it has none; findings go to `add`."""

    names: Names
    top: Callable[[str], ScenePlace | None]
    add: Callable[[Diagnostic, Path], None]

    def stacked(self, thing: Thing, group: StackGroup) -> Thing:
        """A thing of a stack: on the surface of the group, or on the top of the thing below it."""
        assert thing.group is not None, "a stack is a group"
        order, path = self.names.stacked(thing.group), ("layout", "groups", thing.group)
        number = order.index(thing.name)
        if number == 0:
            return thing
        below = order[number - 1]
        top = self.top(below)
        if top is None:
            headline = f"`{below}` has no surface on which `{thing.name}` could stand"
            self.add(finding("scene/missing-anchor", headline), (*path, "members"))
            return thing
        level = stack_level(top, thing.body, group, path)
        return replace(thing, parent=below, place=level.place, domain=level.domain)

    def with_frames(self, things: dict[str, Thing]) -> dict[str, Thing]:
        """The things, with the frame of each grid before its members."""
        for name, group in self.names.grids.items():
            members = [things[thing] for thing in self.names.things_named(name) if thing in things]
            if len(members) == len(group.cells()):
                framed = {thing.name: thing for thing in with_frame(name, group, members, ("layout", "groups", name))}
                things = {thing: at for thing, at in things.items() if thing not in framed} | framed
        return things

    def stacks(self, things: Mapping[str, Thing]) -> tuple[tuple[str, ...], ...]:
        """The things of each stack, the lowest first; a finding for each that may fall."""
        stacks: list[tuple[str, ...]] = []
        for name, group in self.names.program.layout.groups.items():
            order = self.names.stacked(name)
            if not isinstance(group, StackGroup) or not order or any(thing not in things for thing in order):
                continue
            stacks.append(order)
            levels = [(things[thing].body, top) for thing in order if (top := self.top(thing)) is not None]
            levels += [(things[order[-1]].body, things[order[-1]].place)] if len(levels) == len(order) - 1 else []
            beyond = most_off_balance_m(levels, group.alignment) if len(levels) == len(order) else 0.0
            if beyond > 0.0:
                headline = f"`layout.groups.{name}` may fall: within its alignment a load is {1e3 * beyond:.3g} mm "
                headline += "outside of what carries it"
                more = {"value": 1e3 * beyond, "bound": 0.0, "unit": "mm"}
                self.add(finding("scene/stack-unsteady", headline, **more), ("layout", "groups", name, "alignment"))
        return tuple(stacks)
