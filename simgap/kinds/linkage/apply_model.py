"""The declared jointed body with terms applied."""

from __future__ import annotations

from dataclasses import dataclass, replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import BodyWrench, ModelChange, Params, SensorMap, Series
from sim.dynamics.linkage_rollout import LinkageModel, link_body, with_link_body
from sim.dynamics.mechanism import Law
from sim.effects.common.joint_values import joint_index
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.problem import Model, Term

WHOLE = "body"  # the place of effects on all links alike


@dataclass(frozen=True)
class AppliedLinkage(AppliedBody):
    """A model as inputs of a roll-out; `body` is the base with the mass of the whole linkage."""

    linkage: LinkageModel
    laws: tuple[Law, ...]


def apply_terms(declared: LinkageModel, model: Model) -> AppliedLinkage:
    """`declared` with the terms of `model` in their order; a later term of the same number replaces an earlier one."""
    linkage, wrenches, laws, sensors = declared, [], [], []
    for term in model:
        hook, where = term.candidate.effect.hook, term.candidate.where
        if isinstance(hook, ModelChange):
            linkage = _changed(linkage, hook, term)
        elif isinstance(hook, BodyWrench):
            wrenches.append((hook, term.values))
        elif isinstance(hook, SensorMap):
            sensors.append((_at_joint(hook, declared, term), term.values, where))
        else:
            laws.append(Law(hook, term.values, joint_index(declared.joints, where)))
    whole = replace(linkage.base, mass_kg=linkage.mass_kg)
    return AppliedLinkage(whole, tuple(wrenches), tuple(sensors), linkage, tuple(laws))


def _changed(linkage: LinkageModel, hook: ModelChange, term: Term) -> LinkageModel:
    where = term.candidate.where
    if term.candidate.effect.family == "joint":
        return replace(linkage, joints=hook.change(linkage.joints, term.values, where))
    if where.body is None:
        return replace(linkage, base=hook.change(linkage.base, term.values, where))
    for name in linkage.names if where.body == WHOLE else (where.body,):
        linkage = with_link_body(linkage, name, hook.change(link_body(linkage, name), term.values, where))
    return linkage


def _at_joint(hook: SensorMap, declared: LinkageModel, term: Term) -> SensorMap:
    """The map for the columns that it means: a length scale leaves angles alone, a joint's bias other joints."""
    where = term.candidate.where
    if where.joint is not None:
        joint = joint_index(declared.joints, where)
        return SensorMap(_one_joint(hook.report, joint), _one_joint(hook.recover, joint))
    if hook.spares_joints:
        return SensorMap(_without_joints(hook.report), _without_joints(hook.recover))
    return hook


def _one_joint(change, joint: int):
    def map_one(series: Series, params: Params, where: Place) -> Series:
        columns = dict(series.columns)
        own = {n: columns[n][:, joint : joint + 1] for n in ("q", "qd") if n in columns}
        for name, values in change(Series(series.t_s, own), params, where).columns.items():
            columns[name] = columns[name].copy()
            columns[name][:, joint : joint + 1] = values
        return replace(series, columns=columns)

    return map_one


def _without_joints(change):
    def map_rest(series: Series, params: Params, where: Place) -> Series:
        joints = {n: v for n, v in series.columns.items() if n in ("q", "qd")}
        rest = {n: v for n, v in series.columns.items() if n not in joints}
        changed = change(replace(series, columns=rest), params, where)
        return replace(changed, columns={**changed.columns, **joints})

    return map_rest
