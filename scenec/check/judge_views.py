"""Judges cameras: whether one can be drawn in a compiled scene, and whether drawn ones show what they must.

The first draws as plans do (`runtime_plan.cameras`); the second counts pixels again, by the z-buffer of `scene_check`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from runtime_plan.cameras import TRIES, SceneBody, bodies_of, view
from runtime_plan.plan import prepare
from runtime_plan.sampler import sample
from scene_check.views import pixels_by_object
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.cameras import Camera
from schemas.scene.compiled import CompiledScene, PlacedObject
from schemas.scene.geometry import BACKGROUND
from schemas.scene.program import SceneProgram
from schemas.scene.runtime_plan import RuntimePlan
from source.tree import Spans

JUDGED_DRAWS = 64  # scenes of a plan in which every camera must have a view


def without_view(
    program: SceneProgram, scenes: Sequence[CompiledScene], seed: int, spans: Spans
) -> Iterator[Diagnostic]:
    """A finding (`scene/no-view`) for each camera of which no try shows what it must in some scene. Raises
    RuntimeError when the z-buffer refuses a drawn one: a defect of ours."""
    for number, camera in enumerate(program.cameras):
        for index, scene in enumerate(scenes):
            bodies = {placed.id: _body(placed) for placed in scene.objects}
            if scene.background is not None:
                bodies[BACKGROUND] = _body(scene.background)
            if not _shows(camera, number, bodies, seed, index):
                text = f"none of {TRIES} cameras `{camera.id}` within its ranges shows {_demand(camera)}"
                where = spans.place(("cameras", number, "visible"))
                yield finding("scene/no-view", text, where=where, value=TRIES, unit="tries")
                break


def plan_without_view(document: RuntimePlan, seed: int, spans: Spans) -> Iterator[Diagnostic]:
    """As `without_view`, for `JUDGED_DRAWS` scenes drawn from a plan."""
    if not document.cameras:
        return
    plan = prepare(document)
    samples = sample(plan, JUDGED_DRAWS, seed)
    scenes = [bodies_of(plan, samples, k) for k in range(JUDGED_DRAWS)]
    for number, camera in enumerate(document.cameras):
        blocked = sum(not _shows(camera, number, bodies, seed, k) for k, bodies in enumerate(scenes))
        if blocked:
            text = f"in {blocked} of {JUDGED_DRAWS} scenes drawn from the plan none of {TRIES} cameras `{camera.id}` "
            text += f"within its ranges shows {_demand(camera)}"
            where = spans.place(("cameras", number, "visible"))
            yield finding("scene/no-view", text, where=where, value=blocked, bound=0, unit="scenes")


def _shows(camera: Camera, number: int, bodies: Mapping[str, SceneBody], seed: int, index: int) -> bool:
    """Whether a camera can be drawn. Raises RuntimeError when the z-buffer refuses it."""
    pose = view(camera, number, bodies, seed, index)
    if pose is None:
        return False
    pixels = pixels_by_object(pose, {name: body.prisms for name, body in bodies.items()})
    for rule in camera.visible:
        if pixels[rule.object] < rule.pixels:
            raise RuntimeError(f"camera `{camera.id}` shows {pixels[rule.object]} pixels of {rule}")
    return True


def _demand(camera: Camera) -> str:
    return " and ".join(f"{rule.pixels} pixels of `{rule.object}`" for rule in camera.visible)


def _body(placed: PlacedObject) -> SceneBody:
    w, _, _, z = placed.quat_wxyz
    return SceneBody(placed.prisms, np.array(placed.position_m), float(2.0 * np.arctan2(z, w)))
