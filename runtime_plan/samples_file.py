"""Convert samples between arrays and the JSON document `SceneSamples`: poses in W (m, quaternions wxyz)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from runtime_plan.cameras import draw_cameras
from runtime_plan.plan import Plan
from runtime_plan.samples import Samples
from runtime_plan.tables import ABSENT, AUTHORED, BACKGROUND_COLUMN
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.scene.geometry import BACKGROUND
from schemas.scene.runtime_plan import PlanCombination
from schemas.scene.samples import SampledLighting, SampledObject, SceneSample, SceneSamples

NORM_TOLERANCE = 1e-6  # how far the norm of a quaternion may be from 1
_CHANNELS = ("intensity", "exposure", "temperature_K", "rotation")


def as_document(plan: Plan, samples: Samples) -> SceneSamples:
    """Samples as a document, with indices replaced by the names of the plan."""
    return SceneSamples(plan=plan.sha256, seed=samples.seed, samples=tuple(_documents(plan, samples)))


def _documents(plan: Plan, samples: Samples) -> Iterator[SceneSample]:
    bodies, materials, names = plan.document.bodies, plan.document.materials, samples.names

    def material(index: int) -> str | None:
        return None if index == AUTHORED else materials[index].id

    for k in range(len(samples)):
        combination = int(samples.combination[k])
        rows: Iterable[tuple[int, Any, Any, int, int]] = zip(
            samples.asset_index[k].tolist(), samples.position_m[k].tolist(), samples.quat_wxyz[k].tolist(),
            samples.support[k].tolist(), samples.material[k].tolist(), strict=True,
        )  # fmt: skip
        objects = {
            name: SampledObject(
                asset=bodies[body].asset_id,
                position_m=tuple(position),
                quat_wxyz=tuple(quat),
                support=BACKGROUND if owner == BACKGROUND_COLUMN else names[owner],
                material=material(material_index),
            )
            for name, (body, position, quat, owner, material_index) in zip(names, rows, strict=True)
            if body >= 0
        }
        background = int(samples.background[k])
        pools = len(plan.document.combinations[combination].pools)
        yield SceneSample(
            index=samples.start + k,
            combination=combination,
            case=tuple(samples.case[k, :pools].tolist()),
            objects=objects,
            lighting=sampled_lighting(plan, samples, k),
            cameras=draw_cameras(plan, samples, k),
            rise_m=float(samples.rise_m[k]),
            background=None if background < 0 else bodies[background].asset_id,
            background_material=material(int(samples.background_material[k])),
        )


def sampled_lighting(plan: Plan, samples: Samples, k: int) -> SampledLighting | None:
    """The lighting of sample k with its channels as drawn; None for none."""
    index = int(samples.lighting[k])
    if index < 0:
        return None
    channels = zip(_CHANNELS, samples.channels[k].tolist(), strict=True)
    return SampledLighting(
        id=plan.document.lighting[index].id, **{name: value for name, value in channels if value == value}
    )


def read_samples(path: Path | str, plan: Plan) -> tuple[tuple[int, ...], Samples]:
    """Indices and arrays of a file of samples of this plan; `stance` is -1 and `yaw_rad` NaN: poses alone are kept.

    Raises InvalidInput: `plan/missing-file`, `plan/unreadable-samples`, `plan/other-plan`.
    """
    path = Path(path)
    here = Location(file=path.name)
    if not path.is_file():
        raise InvalidInput(finding("plan/missing-file", f"there is no file {path}", where=here))
    try:
        document = SceneSamples.model_validate_json(path.read_bytes())
    except ValidationError as refused:
        first = refused.errors(include_url=False, include_input=False)[0]
        text = f"{path.name}: {'.'.join(str(part) for part in first['loc'])}: {first['msg']}"
        raise InvalidInput(finding("plan/unreadable-samples", text, where=here)) from None
    if document.plan != plan.sha256:
        text = f"{path.name} holds samples of another plan"
        raise InvalidInput(
            finding("plan/other-plan", text, where=here, value=document.plan[:12], bound=plan.sha256[:12])
        )
    defect = _defect(document)
    if defect:
        raise InvalidInput(finding("plan/unreadable-samples", f"{path.name}: {defect}", where=here))
    try:
        return tuple(sample.index for sample in document.samples), _arrays(plan, document)
    except (KeyError, IndexError, ValueError) as wrong:
        text = f"{path.name} names what the plan does not have: {wrong}"
        raise InvalidInput(finding("plan/unreadable-samples", text, where=here)) from None


def _defect(document: SceneSamples) -> str:
    """Why the samples cannot be judged; empty when they can."""
    if not document.samples:
        return "it holds no sample"
    indices = [sample.index for sample in document.samples]
    if len(set(indices)) < len(indices):
        return "two samples have one index"
    for sample in document.samples:
        for name, item in sample.objects.items():
            if not np.isfinite(item.position_m).all():
                return f"sample {sample.index}: the position of `{name}` is not finite"
            if not abs(float(np.linalg.norm(item.quat_wxyz)) - 1.0) <= NORM_TOLERANCE:
                return f"sample {sample.index}: the quaternion of `{name}` has no unit length"
    return ""


def _arrays(plan: Plan, document: SceneSamples) -> Samples:
    n, names, drawn_plan = len(document.samples), plan.tables.names, plan.document
    column = {name: index for index, name in enumerate(names)} | {BACKGROUND: BACKGROUND_COLUMN}
    material = {paired.id: index for index, paired in enumerate(drawn_plan.materials)} | {None: AUTHORED}
    light = {lighting.id: index for index, lighting in enumerate(drawn_plan.lighting)}
    most_pools = max(len(combination.pools) for combination in drawn_plan.combinations)
    shape = (n, len(names))
    samples = Samples(
        seed=document.seed,
        start=document.samples[0].index if n else 0,
        names=names,
        combination=np.array([sample.combination for sample in document.samples], dtype=np.int64),
        case=np.full((n, most_pools), -1),
        present=np.zeros(shape, dtype=bool),
        asset_index=np.full(shape, -1),
        stance=np.full(shape, -1),
        support=np.full(shape, ABSENT),
        position_m=np.full((*shape, 3), np.nan),
        quat_wxyz=np.full((*shape, 4), np.nan),
        yaw_rad=np.full(shape, np.nan),
        material=np.full(shape, AUTHORED),
        background_material=np.array(
            [material[sample.background_material] for sample in document.samples], dtype=np.int64
        ),
        background=np.full(n, -1),
        lighting=np.full(n, -1),
        channels=np.full((n, 4), np.nan),
        rise_m=np.array([sample.rise_m for sample in document.samples]),
    )
    for k, sample in enumerate(document.samples):
        combination = drawn_plan.combinations[sample.combination]
        samples.case[k, : len(combination.pools)] = sample.case
        samples.background[k] = -1 if combination.background is None else combination.background
        for name, item in sample.objects.items():
            at = column[name]
            samples.present[k, at] = True
            samples.asset_index[k, at] = _body(plan, combination, name, item.asset)
            samples.support[k, at] = column[item.support]
            samples.position_m[k, at], samples.quat_wxyz[k, at] = item.position_m, item.quat_wxyz
            samples.material[k, at] = material[item.material]
        if sample.lighting is not None:
            samples.lighting[k] = light[sample.lighting.id]
            drawn = [getattr(sample.lighting, name) for name in _CHANNELS]
            samples.channels[k] = [np.nan if value is None else value for value in drawn]
    return samples


def _body(plan: Plan, combination: PlanCombination, name: str, asset: str) -> int:
    """Index of the body with this asset among the bodies of the thing."""
    thing = next((thing for thing in combination.things if thing.id == name), None)
    matching = [body for body in (thing.bodies if thing else ()) if plan.document.bodies[body].asset_id == asset]
    if not matching:
        raise ValueError(f"`{name}` as `{asset}`")
    return matching[0]
