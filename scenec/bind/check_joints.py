"""Checks the joint states and the joints kept clear of a program against every asset that may play the object."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.joint_states import joint_named, joint_state, unknown_joint
from scenec.ir.names import Names
from scenec.ir.single_assets import SingleAsset, single_assets
from schemas.diagnostics import Diagnostic
from schemas.scene.geometry import BACKGROUND
from schemas.scene.program import FixedAsset, SceneProgram
from source.tree import Path, Spans


def check_joints(names: Names, library: AssetLibrary, spans: Spans) -> tuple[Diagnostic, ...]:
    """Findings about `joints` and `keep_clear`, each where the joint is named; assets must have been checked."""
    program = names.program
    if not any(node.joints for node in program.layout.nodes.values()) and not program.keep_clear:
        grounds = [program.background, *(variant.background for variant in program.variants.backgrounds)]
        if not any(ground is not None and ground.joints for ground in grounds):
            return ()
    findings: dict[tuple[str, Path], Diagnostic] = {}
    for path, diagnostic in (*_states(program, library), *_kept_clear(names, library)):
        findings.setdefault((diagnostic.code, path), diagnostic.model_copy(update={"where": spans.place(path)}))
    return tuple(findings.values())


def _states(program: SceneProgram, library: AssetLibrary) -> Iterator[tuple[Path, Diagnostic]]:
    written = [
        (("layout", "nodes", name, "joints"), node.joints, _candidates(program, node.object))
        for name, node in program.layout.nodes.items()
    ]
    grounds = [(("background",), program.background)]
    grounds += [
        (("variants", "backgrounds", i, "background"), variant.background)
        for i, variant in enumerate(program.variants.backgrounds)
    ]
    written += [
        ((*path, "joints"), ground.joints, single_assets(ground.asset))
        for path, ground in grounds
        if ground is not None
    ]
    for path, joints, assets in written:
        for asset in assets if joints else ():
            _, findings = joint_state(_name(asset), library.mechanism(asset), joints)
            yield from (((*path, key), diagnostic) for key, diagnostic in findings)


def _kept_clear(names: Names, library: AssetLibrary) -> Iterator[tuple[Path, Diagnostic]]:
    program = names.program
    for i, rule in enumerate(program.keep_clear):
        for asset in _kept_assets(names, rule.object):
            mechanism = library.mechanism(asset)
            if mechanism is None or joint_named(mechanism, rule.joint) is None:
                yield ("keep_clear", i, "joint"), unknown_joint(_name(asset), mechanism, rule.joint)


def _kept_assets(names: Names, owner: str) -> tuple[SingleAsset, ...]:
    program = names.program
    if owner == BACKGROUND:
        grounds = [program.background, *(variant.background for variant in program.variants.backgrounds)]
        return tuple(asset for ground in grounds if ground is not None for asset in single_assets(ground.asset))
    return _candidates(program, names.object_of(owner))


def _candidates(program: SceneProgram, name: str) -> tuple[SingleAsset, ...]:
    """Every asset that may play an object: as written, and in each asset variant."""
    written = [thing.asset for thing in program.objects if thing.id == name]
    written += [variant.objects[name] for variant in program.variants.assets if name in variant.objects]
    return tuple(asset for one in written for asset in single_assets(one))


def _name(asset: SingleAsset) -> str:
    return asset.id if isinstance(asset, FixedAsset) else asset.type
