"""The variant space of a program: keys such as `objects.mug` or `variants.backgrounds`, each with its possible values.

Variants that change geometry are resolved before anything is placed: a combination gives every key one value.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from math import prod

from scenec.ir.names import Names, upright
from scenec.ir.single_assets import SingleAsset, single_assets
from schemas.scene.placing import SlotGroup
from schemas.scene.program import AssetVariant, Background, FixedAsset

MAX_COMBINATIONS = 256
AS_WRITTEN = "as_written"
ASSETS, BACKGROUNDS, BACKGROUND_POOL = "variants.assets", "variants.backgrounds", "background"
Combination = dict[str, str]


@dataclass(frozen=True)
class Choice:
    """One combination resolved: assets of each object (several: their union), background and slot assignments."""

    combination: Combination
    objects: Mapping[str, tuple[SingleAsset, ...]]
    background: Background | None
    background_asset: SingleAsset | None
    assign: dict[str, dict[str, str]] = field(default_factory=dict)


class VariantSpace:
    """Keys and values of a program. Objects in `united` stand for all their candidates at once and have no key.

    A pool is a key only under those asset variants that leave the object a pool.
    """

    def __init__(self, names: Names) -> None:
        program, variants = names.program, names.program.variants
        self.names = names
        self.assets: dict[str, AssetVariant | None] = {AS_WRITTEN: None, **{v.id: v for v in variants.assets}}
        self.backgrounds: dict[str, Background | None] = {v.id: v.background for v in variants.backgrounds}
        if program.background is not None or not self.backgrounds:
            self.backgrounds = {AS_WRITTEN: program.background, **self.backgrounds}
        self.slots: dict[str, dict[str, dict[str, str]]] = {v.group: {AS_WRITTEN: {}} for v in variants.slots}
        for variant in variants.slots:
            self.slots[variant.group][variant.id] = variant.assign
        self.as_authored = {thing.id: single_assets(thing.asset) for thing in program.objects}
        self.united = frozenset(entry.id for entry in program.distractors)

    @property
    def is_open(self) -> bool:
        """Whether any key has several values."""
        pools = any(len(candidates) > 1 for candidates in self.as_authored.values())
        return pools or len(self.assets) > 1 or bool(self.slots) or bool(self.background_keys())

    def candidates(self, name: str, variant: str) -> tuple[SingleAsset, ...]:
        """The candidates of an object under an asset variant."""
        changed = self.assets[variant]
        asset = None if changed is None else changed.objects.get(name)
        return self.as_authored[name] if asset is None else single_assets(asset)

    def background_keys(self) -> frozenset[str]:
        """Keys of the background; they affect every thing."""
        pool = any(b is not None and len(single_assets(b.asset)) > 1 for b in self.backgrounds.values())
        return frozenset([*([BACKGROUNDS] if len(self.backgrounds) > 1 else []), *([BACKGROUND_POOL] if pool else [])])

    def keys_of(self, node: str) -> frozenset[str]:
        """Keys that affect a node directly: its asset, its slots."""
        name = self.names.program.layout.nodes[node].object
        pool = any(len(self.candidates(name, variant)) > 1 for variant in self.assets)
        changed = any(variant is not None and name in variant.objects for variant in self.assets.values())
        groups = [group for group in self.names.groups_of.get(node, ()) if group in self.slots]
        slots = [slot_key(g) for g in groups if isinstance(self.names.program.layout.groups[g], SlotGroup)]
        object_keys = [f"objects.{name}"] if pool and name not in self.united else []
        return frozenset([*object_keys, *([ASSETS] if changed else []), *slots])

    def count(self, keys: Collection[str]) -> int:
        """How many combinations of the values of some keys there are, without listing them."""
        slots = prod(len(choices) for group, choices in self.slots.items() if slot_key(group) in keys)
        others = [key for key in keys if key not in map(slot_key, self.slots)]
        return slots * sum(self._size(variant, background, keys) for variant, background, _ in self._settings(others))

    def combinations(self, keys: Collection[str]) -> Iterator[Combination]:
        """Every combination of the values of some keys; values as authored come first."""
        for variant, background, assigned in self._settings(keys):
            declared = {ASSETS: variant, BACKGROUNDS: background, **assigned}
            pools = {f"objects.{name}": candidates for name, candidates in self._pools(variant, keys)}
            behind = self._behind(background, keys)
            for at, *chosen in product(behind, *pools.values()):
                picked = {key: one.id for key, one in zip(pools, chosen, strict=True) if isinstance(one, FixedAsset)}
                last = {BACKGROUND_POOL: at.id} if len(behind) > 1 and isinstance(at, FixedAsset) else {}
                yield {**{key: value for key, value in declared.items() if key in keys}, **picked, **last}

    def probes(self) -> Iterator[Combination]:
        """Combinations of all keys that pair each candidate of each thing with each background and each assignment of
        its own slot group."""
        declared = frozenset([ASSETS, *self.background_keys()])
        every = declared | {f"objects.{name}" for name in self.as_authored}
        assignments = range(max(map(len, self.slots.values()), default=1))
        for one, n in product(self.combinations(declared), assignments):
            slots = {slot_key(group): [*choices][min(n, len(choices) - 1)] for group, choices in self.slots.items()}
            pools = dict(self._pools(one.get(ASSETS, AS_WRITTEN), every))
            for k in range(max(map(len, pools.values()), default=1)):
                picked = {
                    f"objects.{name}": candidates[min(k, len(candidates) - 1)] for name, candidates in pools.items()
                }
                named = {key: single.id for key, single in picked.items() if isinstance(single, FixedAsset)}
                yield one | slots | named

    def choice(self, combination: Mapping[str, str]) -> Choice:
        """The choices of a combination; a missing key has its first value, or all values for `united` objects."""
        variant = combination.get(ASSETS, AS_WRITTEN)
        background = self.backgrounds[combination.get(BACKGROUNDS, next(iter(self.backgrounds)))]
        objects = {}
        for name in self.as_authored:
            candidates = self.candidates(name, variant)
            one = combination.get(f"objects.{name}")
            objects[name] = candidates if name in self.united and one is None else (_named(candidates, one),)
        behind = None
        if background is not None:
            behind = _named(single_assets(background.asset), combination.get(BACKGROUND_POOL))
        assign = {group: choices[combination.get(slot_key(group), AS_WRITTEN)] for group, choices in self.slots.items()}
        return Choice(dict(combination), objects, background, behind, assign)

    def must_be_separate(self) -> frozenset[str]:
        """Objects whose candidates cannot be united: other things stand on them, they may be turned over, or a program
        names their joints."""
        names = self.names
        nodes = names.program.layout.nodes
        used = {anchor for node in nodes if (anchor := names.anchor_of(node)) is not None}
        owners = {names.owner(anchor) for anchor in used}
        carriers = (node.object for name, node in nodes.items() if not owners.isdisjoint(names.copies[name]))
        turned = (node.object for name, node in nodes.items() if not upright(names.placing(name)))
        jointed = (node.object for node in nodes.values() if node.joints)
        stacks = (thing for group in names.program.layout.groups for thing in names.stacked(group)[:-1])
        stacked = (nodes[names.node_of[thing]].object for thing in stacks)
        kept_clear = (names.object_of(rule.object) for rule in names.program.keep_clear)
        return frozenset((*carriers, *turned, *jointed, *kept_clear, *stacked, *names.named_by_parts))

    def _settings(self, keys: Collection[str]) -> Iterator[tuple[str, str, Combination]]:
        # Asset variant, background and slot assignments of each choice of the declared variants among `keys`.
        variants = [*self.assets] if ASSETS in keys else [AS_WRITTEN]
        backgrounds = [*self.backgrounds] if BACKGROUNDS in keys else [next(iter(self.backgrounds))]
        groups = [group for group in self.slots if slot_key(group) in keys]
        for variant, background, *assigned in product(variants, backgrounds, *(self.slots[group] for group in groups)):
            yield variant, background, dict(zip(map(slot_key, groups), assigned, strict=True))

    def _pools(self, variant: str, keys: Collection[str]) -> Iterator[tuple[str, tuple[SingleAsset, ...]]]:
        for name in self.as_authored:
            candidates = self.candidates(name, variant)
            if len(candidates) > 1 and name not in self.united and f"objects.{name}" in keys:
                yield name, candidates

    def _behind(self, background: str, keys: Collection[str]) -> tuple[SingleAsset | None, ...]:
        background_choice = self.backgrounds[background]
        candidates = () if background_choice is None else single_assets(background_choice.asset)
        return candidates if BACKGROUND_POOL in keys and candidates else candidates[:1] or (None,)

    def _size(self, variant: str, background: str, keys: Collection[str]) -> int:
        count = len(self._behind(background, keys))
        for _, candidates in self._pools(variant, keys):
            count *= len(candidates)
        return count


def slot_key(group: str) -> str:
    """The key of a slot group's assignments."""
    return f"variants.slots.{group}"


def _named(candidates: tuple[SingleAsset, ...], name: str | None) -> SingleAsset:
    return next((one for one in candidates if isinstance(one, FixedAsset) and one.id == name), candidates[0])
