"""Binds one combination of a program to geometry: a problem of things on places, relations, keep-outs and reach."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import shapely

from scenec.bind.asset_library import AssetLibrary, Geometry
from scenec.bind.bind_relations import lower_relations
from scenec.bind.choice_spans import candidate_path
from scenec.bind.group_things import GroupThings
from scenec.bind.joint_states import JointState, joint_named, joint_state
from scenec.bind.posed_asset import TILT_DEG
from scenec.bind.swept_space import swept_space
from scenec.bind.variants import AS_WRITTEN, ASSETS, Choice
from scenec.bind.written_poses import domain_at, fixed_pose_of, orientation_of, world_pose_of, yaw_of, yaw_range_of
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.names import Names, anchor_named, kind_of
from scenec.ir.problem import Body, Problem, Thing, is_round, level_share
from scenec.ir.single_assets import SingleAsset
from schemas.diagnostics import Diagnostic, InvalidInput, Label, any_error, finding
from schemas.scene.geometry import (
    BACKGROUND,
    Domain,
    KeepClear,
    KeepOutVolume,
    ReachRing,
    ScenePlace,
    SceneRelation,
)
from schemas.scene.placing import DiscretePlacement, Group, Orientation, Placement, Ranges, SlotGroup, StackGroup
from schemas.scene.program import FixedAsset, SceneObject
from source.tree import Path, Spans

RESTS_DEG = 3.0  # largest tilt of a thing when it is released (design: a scene settles)


class Lowering:
    """Lowers one combination, of some nodes with all they carry and stand on, or of all (`nodes` None).

    Findings are collected in `diagnostics`; the items that they concern are left out of the problem.
    """

    def __init__(
        self,
        names: Names,
        choice: Choice,
        library: AssetLibrary,
        spans: Spans,
        derivations: DerivationCache,
        nodes: Collection[str] | None = None,
    ) -> None:
        self.nodes = names.program.layout.nodes if nodes is None else nodes
        self.names, self.choice, self.library, self.spans, self.derivations = names, choice, library, spans, derivations
        self.program = names.program
        self.diagnostics: list[Diagnostic] = []
        self.diagnostics_by_path: list[tuple[Path, Diagnostic]] = []  # without lines, for reuse when lines shift
        self.places: dict[tuple[str, str], tuple[str, ScenePlace] | None] = {}
        self.objects = {thing.id: thing for thing in self.program.objects}
        self.groups = GroupThings(names, self._top, self._add)

    def problem(self) -> Problem:
        """The problem, with the relations, keep-outs and reach of its things."""
        program, background = self.program, self.choice.background
        nodes = (node for node in program.layout.nodes if node in self.nodes)
        things = {thing.name: thing for node in nodes for thing in self._things(node)}
        things = self.groups.with_frames(things)
        background_yaw = yaw_of(background) if background is not None else 0.0
        relations: tuple[SceneRelation, ...] = ()
        if not any_error(self.diagnostics):
            relations, wrong = lower_relations(self.names, things, background_yaw, self.spans)
            self.diagnostics += wrong
            relations = tuple(self.derivations.get(rule, partial(_itself, rule)) for rule in relations)
        keep_outs = (self._keep_out(i) for i in range(len(program.keep_outs)))
        return Problem(
            program.scene,
            self._background(),
            world_pose_of(background),
            tuple(things.values()),
            relations,
            program.clearance,
            tuple(k for k in keep_outs if k is not None and (k.parent == BACKGROUND or k.parent in things)),
            self._reach(things),
            dict(self.choice.combination),
            self._keep_clear(things),
            0.0 if background is None or background.height is None else background.height[1] - background.height[0],
            self.groups.stacks(things),
        )

    def _background(self) -> Body | None:
        background, asset = self.choice.background, self.choice.background_asset
        if background is None or asset is None:
            return None
        return self.library.body(asset, background.scale, state=self._state(asset, background.joints))

    def _state(self, asset: SingleAsset, joints: Mapping[str, float]) -> JointState:
        """The joint state of an asset; `check_joints` has found it valid."""
        return joint_state("", self.library.mechanism(asset), joints)[0] if joints else ()

    def _posed(self, owner: str) -> tuple[SingleAsset, float, JointState] | None:
        """Asset, scale and joint state of the background or a thing, the first candidate; None without background."""
        if owner == BACKGROUND:
            background, asset = self.choice.background, self.choice.background_asset
            if background is None or asset is None:
                return None
            return asset, background.scale, self._state(asset, background.joints)
        node = self.program.layout.nodes[self.names.node_of[owner]]
        asset = self.choice.objects[node.object][0]
        return asset, self.objects[node.object].scale, self._state(asset, node.joints)

    # Things.

    def _things(self, node: str) -> Sequence[Thing]:
        """The things of a node; without a group, they stay the same Python objects while nothing of it changes."""
        layout, placing = self.program.layout, self.names.placing(node)
        assert placing is not None, "the checks of the text ask for one owner"
        placed = self._place(anchor_named(placing), kind_of(placing))
        if placed is None:
            return ()
        parent, place = placed
        written = self.objects[layout.nodes[node].object]
        if layout.nodes[node].placement is None:
            return self._bound_things(node, placing, written, parent, place)[0]
        joints = layout.nodes[node].joints
        geometries = [
            self.library.geometry(asset, written.scale, self._state(asset, joints))
            for asset in self.choice.objects[written.id]
        ]
        things, diagnostics = self.derivations.get(
            ("things", node, parent, *map(id, geometries)),
            lambda: self._bound_things(node, placing, written, parent, place),
            *(layout.nodes[node], written, place, *geometries),
        )
        for at, diagnostic in diagnostics:
            self._add(diagnostic, at)
        return things

    def _bound_things(
        self, node: str, placing: Placement | Group, written: SceneObject, parent: str, place: ScenePlace
    ) -> tuple[tuple[Thing, ...], tuple[tuple[Path, Diagnostic], ...]]:
        """The things of a node, and findings about them, each with its path."""
        groups, before = self.names.groups_of.get(node, ()), len(self.diagnostics_by_path)
        group = groups[0] if groups else None
        path: Path = ("layout", "nodes", node)
        placed_by: Path = (*path, "placement") if group is None else ("layout", "groups", group)
        orientation, turns = orientation_of(placing)
        inside = place.is_volume
        joints = self.program.layout.nodes[node].joints
        body = self._body(written.id, written.scale, joints, orientation, placed_by, inside)
        domain = self._domain(placing, node, group, body, turns, placed_by)
        if is_round(place) and not domain.fixed_poses:
            self._report_round_floor(place, anchor_named(placing), parent, placed_by)
        things = tuple(
            Thing(name, body, parent, place, domain, path, group, written.semantic_tags)
            for name in self.names.copies[node]
        )
        if isinstance(placing, StackGroup):
            things = tuple(self.groups.stacked(thing, placing) for thing in things)
        return things, tuple(self.diagnostics_by_path[before:])

    def _top(self, name: str) -> ScenePlace | None:
        """The highest surface of a thing, None where it has none."""
        posed = self._posed(name)
        surfaces = self.library.geometry(*posed).surfaces if posed is not None else ()
        return max(surfaces, key=lambda surface: float(surface.origin_P_m[2]), default=None)

    def _body(
        self,
        name: str,
        scale: float,
        joints: Mapping[str, float],
        orientation: Orientation,
        placed_by: Path,
        inside: bool,
    ) -> Body:
        candidates = [(asset, self._state(asset, joints)) for asset in self.choice.objects[name]]
        for asset, state in candidates:
            self._check_rests(self.library.geometry(asset, scale, state), orientation, placed_by)
        bodies = [self.library.body(asset, scale, orientation, inside, state) for asset, state in candidates]
        return bodies[0] if len(bodies) == 1 else _union(bodies)

    def _check_rests(self, geometry: Geometry, orientation: Orientation, placed_by: Path) -> None:
        """Adds a finding where requested stable poses are unknown, or where an upright thing will fall over."""
        at, lean_deg = (*placed_by, "orientation"), geometry.lean_deg
        if orientation == "stable" and not geometry.stable_quats_wxyz:
            moved = geometry.posed is not None and geometry.posed.moved
            state = " in this state of its joints" if moved else ""
            headline = f"no stable pose of `{geometry.asset_id}` is known{state}"
            self._add(finding("scene/no-stable-pose", headline), at)
        elif orientation == "upright" and geometry.beyond_feet_m > 0.0:
            beyond_mm = 1e3 * geometry.beyond_feet_m
            headline = (
                f"`{geometry.asset_id}` tips over in this state of its joints: its mass centre is {beyond_mm:.3g} "
            )
            headline += "mm beyond what it stands on"
            self._add(finding("scene/topples", headline, value=beyond_mm, bound=0.0, unit="mm"), at)
        elif orientation == "upright" and lean_deg > RESTS_DEG:
            headline = f"`{geometry.asset_id}` does not rest upright: its nearest stable pose leans {lean_deg:.0f} deg"
            self._add(finding("scene/topples", headline, value=lean_deg, bound=RESTS_DEG, unit="deg"), at)

    def _report_round_floor(self, place: ScenePlace, anchor: str, parent: str, placed_by: Path) -> None:
        headline = f"the floor of `{anchor}` in `{parent}` is round: what would lean on its wall is not placed"
        floor_cm2, widest_cm2 = 1e4 * place.floor.area, 1e4 * place.floor.area / level_share(place)
        self._add(finding("scene/round-floor", headline, value=floor_cm2, bound=widest_cm2, unit="cm2"), placed_by)

    def _domain(
        self,
        placing: Placement | Group,
        node: str,
        group: str | None,
        body: Body,
        turns: Sequence[tuple[int, float]],
        path: Path,
    ) -> Domain:
        orientation_indices = tuple(range(len(body.resting_orientations)))
        if isinstance(placing, SlotGroup):
            assert group is not None, "a slot group is one"
            assign = {**placing.assign, **self.choice.assign.get(group, {})}
            taken = {slot for member, slot in assign.items() if member != node}
            fixed_poses = tuple(
                fixed_pose_of(slot, 0, yaw_of(slot), body, slot.id, (*path, "slots", i))
                for i, slot in enumerate(placing.slots)
                if (assign.get(node, slot.id) == slot.id and slot.id not in taken)
            )
            if not fixed_poses:
                headline = f"no slot is left for `{node}`: all are assigned to others"
                self._add(finding("scene/slot-assignment", headline), (*path, "assign"))
            return domain_at(fixed_poses, (*path, "slots"))
        if isinstance(placing, DiscretePlacement):
            fixed_poses = tuple(
                fixed_pose_of(listed, stance, yaw, body, "", (*path, "poses", i))
                for i, (listed, (stance, yaw)) in enumerate(zip(placing.poses, turns, strict=True))
            )
            return domain_at(fixed_poses, (*path, "poses"))
        ranges = placing.ranges
        everywhere = (-np.inf, np.inf)
        return Domain(
            ranges.x or everywhere,
            ranges.y or everywhere,
            yaw_range_of(ranges),
            orientation_indices,
            (),
            (*path, "ranges"),
        )

    # Places.

    def _place(self, anchor: str, kind: Literal["surface", "volume"]) -> tuple[str, ScenePlace] | None:
        """Owner and place of an anchor, None where its owner has no such place; cached."""
        if (anchor, kind) not in self.places:
            self.places[anchor, kind] = self._place_of(anchor, kind)
        return self.places[anchor, kind]

    def _place_of(self, anchor: str, kind: Literal["surface", "volume"]) -> tuple[str, ScenePlace] | None:
        reference, owner = self.program.anchors[anchor], self.names.owner(anchor)
        if owner is None:
            headline = f"`{reference.object}`, on which `{anchor}` is, is never placed"
            self._add(finding("scene/missing-anchor", headline), ("anchors", anchor, "object"))
            return None
        place_name = (reference.surface if kind == "surface" else reference.volume) or "auto"
        posed = self._posed(owner)
        if posed is None:
            headline = f"the anchor `{anchor}` is on the background, and the program has none"
            self._add(finding("scene/missing-anchor", headline), ("anchors", anchor, "object"))
            return None
        asset, scale, state = posed
        find = self.library.surface if kind == "surface" else self.library.volume
        place = find(asset, scale, place_name, anchor, state)
        if place is not None and (place.layers or not place.is_volume):
            return owner, place
        geometry = self.library.geometry(asset, scale, state)
        labels = () if owner == BACKGROUND else self._candidate(self._object_of(owner), asset)
        if isinstance(place_name, str) and place_name in geometry.leaning_deg:
            lean_deg = geometry.leaning_deg[place_name]
            headline = (
                f"`{anchor}`: `{place_name}` of `{geometry.asset_id}` leans {lean_deg:.3g} deg in this state of its "
            )
            headline += "joints: nothing rests on it"
            more = {"value": lean_deg, "bound": TILT_DEG, "unit": "deg", "labels": labels}
            self._add(finding("scene/leaning-anchor", headline, **more), ("anchors", anchor, kind))
            return None
        there = [p.name for p in (geometry.surfaces if kind == "surface" else geometry.volumes)]
        alternatives = f"it has {', '.join(there)}" if there else "it has none"
        named = f"no {kind}" if place_name == "auto" else f"no {kind} `{place_name}`"
        headline = f"`{anchor}`: the asset `{geometry.asset_id}` has {named}" + (
            "" if place_name == "auto" else f"; {alternatives}"
        )
        self._add(finding("scene/missing-anchor", headline, labels=labels), ("anchors", anchor, kind))
        return None

    def _object_of(self, thing: str) -> str:
        return self.program.layout.nodes[self.names.node_of[thing]].object

    def _candidate(self, name: str, asset: SingleAsset) -> tuple[Label, ...]:
        """A label at the candidate of an object that an asset is; none where the object is no pool."""
        variant = self.choice.combination.get(ASSETS, AS_WRITTEN)
        at = candidate_path(self.program, name, asset.id, variant) if isinstance(asset, FixedAsset) else None
        return () if at is None else (Label(where=self.spans.place(at), text=f"a candidate of `{name}`"),)

    def _add(self, diagnostic: Diagnostic, path: Path) -> None:
        """Adds a finding, once, at the current location of the path."""
        here = diagnostic.model_copy(update={"where": self.spans.place(path)})
        self.diagnostics_by_path.append((path, diagnostic))
        if here not in self.diagnostics:
            self.diagnostics.append(here)

    def _keep_out(self, index: int) -> KeepOutVolume | None:
        keep_out = self.program.keep_outs[index]
        placed = self._place(keep_out.surface, "surface")
        if placed is None:
            return None
        parent, place = placed
        assert not place.is_volume, "a surface was asked for"
        if keep_out.outline is not None:
            polygon = shapely.Polygon(keep_out.outline)
        else:
            x0, y0, x1, y1 = place.polygon.bounds
            ranges = keep_out.ranges or Ranges()
            (x0, x1), (y0, y1) = ranges.x or (x0, x1), ranges.y or (y0, y1)
            polygon = shapely.box(x0, y0, x1, y1)
        return KeepOutVolume(parent, place, polygon, keep_out.height or np.inf, ("keep_outs", index))

    def _keep_clear(self, things: Mapping[str, Thing]) -> tuple[KeepClear, ...]:
        """The swept spaces of the joints that are kept clear, for each thing that has the joint."""
        spaces: list[KeepClear] = []
        for i, rule in enumerate(self.program.keep_clear):
            for owner in self.names.placed(rule.object):
                posed = self._posed(owner) if owner == BACKGROUND or owner in things else None
                if posed is None:
                    continue
                asset = self.library.geometry(*posed).posed
                assert asset is not None, "the joint was found"
                joint = joint_named(asset.linkage.mechanism, rule.joint)
                assert joint is not None, "the joint was found"
                try:
                    links, layers = swept_space(asset, joint.name)
                except InvalidInput as error:
                    self._add(error.diagnostic, ("keep_clear", i, "joint"))
                    continue
                spaces.append(KeepClear(owner, joint.name, links, layers, ("keep_clear", i)))
        return tuple(spaces)

    def _reach(self, things: Mapping[str, Thing]) -> ReachRing | None:
        reach = self.program.reach
        if reach is None:
            return None
        named = things if reach.members == "all" else [t for m in reach.members for t in self.names.things_named(m)]
        members = tuple(name for name in dict.fromkeys(named) if name in things)
        return ReachRing(np.array(reach.base), reach.min_radius, reach.radius, members, ("reach",)) if members else None


def _itself(rule: SceneRelation) -> SceneRelation:
    return rule


def _union(bodies: Sequence[Body]) -> Body:
    """The union of bodies in each orientation: where it fits, each of them fits."""
    count = min(len(body.resting_orientations) for body in bodies)
    orientations = tuple(
        replace(
            bodies[0].resting_orientations[k],
            prisms=tuple(prism for body in bodies for prism in body.resting_orientations[k].prisms),
        )
        for k in range(count)
    )
    return replace(bodies[0], resting_orientations=orientations, surfaces=(), volumes=(), candidates=tuple(bodies))
