"""Binds one combination of a program to geometry: a problem of things on places, relations, keep-outs and reach."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import shapely

from geom.pose import pose
from scenec.bind.asset_library import AssetLibrary, Geometry, swing_and_yaw
from scenec.bind.bind_relations import lower_relations
from scenec.bind.choice_spans import candidate_path
from scenec.bind.variants import AS_WRITTEN, ASSETS, Choice
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.names import Names, anchor_named, kind_of
from scenec.ir.problem import Body, Path, Problem, Thing, is_round, level_share
from scenec.ir.single_assets import SingleAsset
from scenec.source.tree import Spans
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Label, any_error, finding
from schemas.scene.geometry import BACKGROUND, Domain, FixedPose, KeepOutVolume, ReachRing, ScenePlace, SceneRelation
from schemas.scene.program import (
    Background,
    DiscretePlacement,
    FixedAsset,
    Group,
    Orientation,
    Placement,
    Pose,
    Ranges,
    SceneObject,
    Slot,
    SlotGroup,
)

FULL_TURN = 2.0 * np.pi
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
        self.object_of = {t: node.object for n, node in self.program.layout.nodes.items() for t in names.copies[n]}

    def problem(self) -> Problem:
        """The problem, with the relations, keep-outs and reach of its things."""
        program, background = self.program, self.choice.background
        nodes = (node for node in program.layout.nodes if node in self.nodes)
        things = {thing.name: thing for node in nodes for thing in self._things(node)}
        background_yaw = _yaw(background) if background is not None else 0.0
        relations: tuple[SceneRelation, ...] = ()
        if not any_error(self.diagnostics):
            relations, wrong = lower_relations(self.names, things, background_yaw, self.spans)
            self.diagnostics += wrong
            relations = tuple(self.derivations.get(rule, partial(_itself, rule)) for rule in relations)
        keep_outs = (self._keep_out(i) for i in range(len(program.keep_outs)))
        return Problem(
            program.scene,
            self._background(),
            _world_pose(background),
            tuple(things.values()),
            relations,
            program.clearance,
            tuple(k for k in keep_outs if k is not None and (k.parent == BACKGROUND or k.parent in things)),
            self._reach(things),
            dict(self.choice.combination),
        )

    def _background(self) -> Body | None:
        background, asset = self.choice.background, self.choice.background_asset
        return None if background is None or asset is None else self.library.body(asset, background.scale)

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
        geometries = [self.library.geometry(asset, written.scale) for asset in self.choice.objects[written.id]]
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
        orientation, turns = _orientation(placing)
        inside = place.is_volume
        body = self._body(written.id, written.scale, orientation, placed_by, inside)
        domain = self._domain(placing, node, group, body, turns, placed_by)
        if is_round(place) and not domain.fixed_poses:
            self._report_round_floor(place, anchor_named(placing), parent, placed_by)
        things = tuple(
            Thing(name, body, parent, place, domain, path, group, written.semantic_tags)
            for name in self.names.copies[node]
        )
        return things, tuple(self.diagnostics_by_path[before:])

    def _body(self, name: str, scale: float, orientation: Orientation, placed_by: Path, inside: bool) -> Body:
        candidates = self.choice.objects[name]
        for asset in candidates:
            self._check_rests(self.library.geometry(asset, scale), orientation, placed_by)
        bodies = [self.library.body(asset, scale, orientation, sections=inside) for asset in candidates]
        return bodies[0] if len(bodies) == 1 else _union(bodies)

    def _check_rests(self, geometry: Geometry, orientation: Orientation, placed_by: Path) -> None:
        """Adds a finding where requested stable poses are unknown, or where an upright thing will fall over."""
        at, lean_deg = (*placed_by, "orientation"), geometry.lean_deg
        if orientation == "stable" and not geometry.stable_quats_wxyz:
            headline = f"no stable pose of `{geometry.asset_id}` is known"
            self._add(finding("scene/no-stable-pose", headline), at)
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
                _fixed_pose(slot, 0, _yaw(slot), body, slot.id, (*path, "slots", i))
                for i, slot in enumerate(placing.slots)
                if (assign.get(node, slot.id) == slot.id and slot.id not in taken)
            )
            if not fixed_poses:
                headline = f"no slot is left for `{node}`: all are assigned to others"
                self._add(finding("scene/slot-assignment", headline), (*path, "assign"))
            return _at(fixed_poses, (*path, "slots"))
        if isinstance(placing, DiscretePlacement):
            fixed_poses = tuple(
                _fixed_pose(listed, stance, yaw, body, "", (*path, "poses", i))
                for i, (listed, (stance, yaw)) in enumerate(zip(placing.poses, turns, strict=True))
            )
            return _at(fixed_poses, (*path, "poses"))
        ranges = placing.ranges
        everywhere = (-np.inf, np.inf)
        return Domain(
            ranges.x or everywhere,
            ranges.y or everywhere,
            _yaw_range(ranges),
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
        if owner == BACKGROUND:
            background = self.choice.background
            assets = (self.choice.background_asset,) if self.choice.background_asset is not None else ()
            scale = background.scale if background is not None else 1.0
        else:
            assets, scale = self.choice.objects[self.object_of[owner]], self.objects[self.object_of[owner]].scale
        if not assets:
            headline = f"the anchor `{anchor}` is on the background, and the program has none"
            self._add(finding("scene/missing-anchor", headline), ("anchors", anchor, "object"))
            return None
        find = self.library.surface if kind == "surface" else self.library.volume
        place = find(assets[0], scale, place_name, anchor)
        if place is not None and (place.layers or not place.is_volume):
            return owner, place
        geometry = self.library.geometry(assets[0], scale)
        there = [p.name for p in (geometry.surfaces if kind == "surface" else geometry.volumes)]
        alternatives = f"it has {', '.join(there)}" if there else "it has none"
        named = f"no {kind}" if place_name == "auto" else f"no {kind} `{place_name}`"
        headline = f"`{anchor}`: the asset `{geometry.asset_id}` has {named}" + (
            "" if place_name == "auto" else f"; {alternatives}"
        )
        labels = () if owner == BACKGROUND else self._candidate(self.object_of[owner], assets[0])
        self._add(finding("scene/missing-anchor", headline, labels=labels), ("anchors", anchor, kind))
        return None

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

    def _reach(self, things: Mapping[str, Thing]) -> ReachRing | None:
        reach = self.program.reach
        if reach is None:
            return None
        named = things if reach.members == "all" else [t for m in reach.members for t in self.names.things_named(m)]
        members = tuple(name for name in dict.fromkeys(named) if name in things)
        return ReachRing(np.array(reach.base), reach.min_radius, reach.radius, members, ("reach",)) if members else None


def _itself(rule: SceneRelation) -> SceneRelation:
    return rule


def _orientation(placing: Placement | Group) -> tuple[Orientation, tuple[tuple[int, float], ...]]:
    """The orientations to prepare; for discrete poses also (number of the orientation, yaw) of each."""
    if isinstance(placing, SlotGroup):
        return "upright", ()
    if not isinstance(placing, DiscretePlacement):
        return placing.orientation, ()
    parts = [swing_and_yaw(pose.quat_wxyz or (1.0, 0.0, 0.0, 0.0)) for pose in placing.poses]
    swings = tuple(dict.fromkeys(swing for swing, _ in parts))
    yaws = [yaw if p.quat_wxyz is not None else _yaw(p) for p, (_, yaw) in zip(placing.poses, parts, strict=True)]
    return swings, tuple((swings.index(swing), yaw) for (swing, _), yaw in zip(parts, yaws, strict=True))


def _fixed_pose(at: Pose | Slot, stance: int, yaw_rad: float, body: Body, name: str, path: Path) -> FixedPose:
    """A fixed pose in A; without an authored `z` the thing rests on its place."""
    z = at.z if "z" in at.model_fields_set else body.resting_orientations[stance].origin_height_m
    return FixedPose(at.x, at.y, z, yaw_rad, name, path, stance)


def _at(fixed_poses: tuple[FixedPose, ...], path: Path) -> Domain:
    """The domain of fixed poses."""
    if not fixed_poses:
        return Domain(path=path)
    xs, ys, yaws = ([getattr(fixed_pose, key) for fixed_pose in fixed_poses] for key in ("x_m", "y_m", "yaw_rad"))
    turn = (min(yaws), max(yaws)) if max(yaws) - min(yaws) < FULL_TURN else (-np.pi, np.pi)
    orientation_indices = tuple(sorted({fixed_pose.stance for fixed_pose in fixed_poses}))
    return Domain((min(xs), max(xs)), (min(ys), max(ys)), turn, orientation_indices, fixed_poses, path)


def _yaw(heading: Background | Pose | Slot) -> float:
    return float(np.radians(heading.yaw_deg)) if heading.yaw_deg is not None else heading.yaw or 0.0


def _yaw_range(ranges: Ranges) -> tuple[float, float]:
    low, high = ranges.yaw or (-np.pi, np.pi)
    if ranges.yaw_deg is not None:
        low, high = (float(np.radians(angle)) for angle in ranges.yaw_deg)
    return (low, high) if high - low < FULL_TURN else (-np.pi, np.pi)


def _world_pose(background: Background | None) -> FloatArray:
    if background is None:
        return np.eye(4)
    c, s = np.cos(_yaw(background)), np.sin(_yaw(background))
    return pose(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), background.position)


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
