"""Combinations of alternatives that change geometry, resolved before anything is placed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import NamedTuple

from scenec.assets import Single
from scenec.names import Names, upright
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.scene_program import Asset, AssetVariant, Background, FixedAsset, PoolAsset, SlotVariant

MAX_COMBINATIONS = 256
AS_WRITTEN = "as_written"
_Named = tuple[str, dict[str, str]]  # an assignment of members to slots, and what it is called


@dataclass(frozen=True)
class Choice:
    """One combination: which assets each object may have (several: their union), background and slots."""

    combination: dict[str, str]
    objects: Mapping[str, tuple[Single, ...]]
    background: Background | None
    background_asset: Single | None
    assign: dict[str, dict[str, str]] = field(default_factory=dict)


class Choices(NamedTuple):
    """All combinations; with `union` pools of things that carry nothing were not taken apart."""

    choices: tuple[Choice, ...]
    union: bool
    diagnostics: tuple[Diagnostic, ...]


def singles(asset: Asset | str) -> tuple[Single, ...]:
    """The assets that an authored asset may be, each once, in order."""
    if isinstance(asset, str):
        return (FixedAsset(type="fixed", id=asset),)
    if isinstance(asset, PoolAsset):
        ids = dict.fromkeys(one for candidates in asset.candidates for one in candidates.assets)
        return tuple(FixedAsset(type="fixed", id=one) for one in ids)
    return (asset,)


def choices(names: Names) -> Choices:
    """Every combination of variants and pool candidates, at most `MAX_COMBINATIONS`.

    Beyond that, pools of upright things that carry nothing keep all their candidates at once (info
    `scene/union-footprints`). Raises InvalidInput (`scene/too-many`) when there are still too many.
    """
    count = sum(_size(setting, frozenset()) for setting in _settings(names))
    if count <= MAX_COMBINATIONS:
        found = tuple(choice for setting in _settings(names) for choice in _combined(setting, frozenset()))
        return Choices(found, False, ())
    together = frozenset(names.objects) - _apart(names)
    left = sum(_size(setting, together) for setting in _settings(names))
    if left > MAX_COMBINATIONS:
        raise InvalidInput(
            finding(
                "scene/too-many",
                f"the variants have {left} combinations that must be solved one by one",
                value=left,
                bound=MAX_COMBINATIONS,
                unit="combinations",
            )
        )
    headline = f"{count} combinations of variants are covered by {left}, with the union of their footprints"
    note = finding("scene/union-footprints", headline, value=count, bound=MAX_COMBINATIONS, unit="combinations")
    found = tuple(choice for setting in _settings(names) for choice in _combined(setting, together))
    return Choices(found, True, (note,))


class _Setting(NamedTuple):
    """One choice of the declared variants, before pools are taken apart."""

    combination: dict[str, str]
    objects: Mapping[str, tuple[Single, ...]]
    background: Background | None
    assign: dict[str, dict[str, str]]


def _settings(names: Names) -> Iterator[_Setting]:
    """Declared variants, each dimension with what the program says without them first."""
    program, variants = names.program, names.program.variants
    written = {thing.id: singles(thing.asset) for thing in program.objects}
    assets: list[AssetVariant | None] = [None, *variants.assets]
    backgrounds: list[tuple[str, Background | None]] = [(v.id, v.background) for v in variants.backgrounds]
    if program.background is not None or not backgrounds:
        backgrounds.insert(0, (AS_WRITTEN, program.background))
    groups = tuple(dict.fromkeys(variant.group for variant in variants.slots))
    for other, (name, background), assigned in product(assets, backgrounds, _assignments(variants.slots, groups)):
        combination = {"variants.assets": other.id if other else AS_WRITTEN} if variants.assets else {}
        combination |= {"variants.backgrounds": name} if len(backgrounds) > 1 else {}
        combination |= {f"variants.slots.{group}": one for group, (one, _) in zip(groups, assigned, strict=True)}
        changed = {of: singles(asset) for of, asset in other.objects.items()} if other else {}
        assign = {group: slots for group, (_, slots) in zip(groups, assigned, strict=True)}
        yield _Setting(combination, written | changed, background, assign)


def _assignments(
    variants: Sequence[SlotVariant], groups: Sequence[str]
) -> list[tuple[tuple[str, dict[str, str]], ...]]:
    """Every choice of one assignment, by name, for each group."""
    written: tuple[str, dict[str, str]] = (AS_WRITTEN, {})
    each = [[written, *((v.id, v.assign) for v in variants if v.group == group)] for group in groups]
    return list(product(*each))


def _size(setting: _Setting, together: frozenset[str]) -> int:
    count = len(singles(setting.background.asset)) if setting.background else 1
    for name, candidates in setting.objects.items():
        count *= 1 if name in together else len(candidates)
    return count


def _combined(setting: _Setting, together: frozenset[str]) -> Iterator[Choice]:
    pools = [name for name, found in setting.objects.items() if len(found) > 1 and name not in together]
    backgrounds: tuple[Single | None, ...] = singles(setting.background.asset) if setting.background else (None,)
    for background, *chosen in product(backgrounds, *(setting.objects[name] for name in pools)):
        picked = dict(zip(pools, chosen, strict=True))
        combination = {f"objects.{name}": one.id for name, one in picked.items() if isinstance(one, FixedAsset)}
        if len(backgrounds) > 1 and isinstance(background, FixedAsset):
            combination["background"] = background.id
        objects = {**setting.objects, **{name: (one,) for name, one in picked.items()}}
        yield Choice(setting.combination | combination, objects, setting.background, background, setting.assign)


def _apart(names: Names) -> frozenset[str]:
    """Objects whose candidates must be solved one by one: something stands on them, or they may be turned over."""
    nodes = names.program.layout.nodes
    used = {anchor for node in nodes if (anchor := names.anchor_of(node)) is not None}
    owners = {names.owner(anchor) for anchor in used}
    carriers = (node.object for name, node in nodes.items() if not owners.isdisjoint(names.copies[name]))
    turned = (node.object for name, node in nodes.items() if not upright(names.placing(name)))
    return frozenset((*carriers, *turned))
