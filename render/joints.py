"""Pictures of an object in motion, through one camera: the strip of a package, frames of an animation.

The camera is that of the hero view around the box that holds the object at all positions, or the same from the corner
where the motion is seen best; the floor lies below all.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer, vtkRenderWindow

from geom.mechanism_pose import link_motions, movable_joints, opened
from geom.pose import apply, pose
from render.camera import HERO_VIEW, AnnotationFrame, CameraView, camera, frame_around, used_points
from render.motion_request import MotionRequest
from render.ready_studio import take_studio
from render.studio import BACKGROUND_SRGB, floor
from render.surface_samples import surface_samples
from render.surfaces import ShadedSurface, actor, surfaces
from render.textures import TextureSet
from render.window import enable_depth_peeling, save_png, take_picture
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism
from schemas.model import Model

STRIP_SHARES = (0.0, 0.5, 1.0)
_TRIAL_PX = 96
_VISIBLE_STEP = 12  # of 255: shadows and shading that change a little do not count
_FAR_MORE = 1.3  # The strip looks like the other pictures where it can.
_LABEL_SRGB, _LABEL_PX, _LABEL_AT = (30, 34, 40), 18, (14, 10)


def draw_motion(request: MotionRequest) -> list[Path]:
    """Write the pictures of `request`, in order. Raises NoOpenGL when the system has no software OpenGL."""
    folder = Path(request.out_dir)
    folder.mkdir(parents=True, exist_ok=True)
    window, renderer = take_studio()
    paths = []
    count = min((len(each) for each in request.motions.values()), default=0)
    motions = [{link: each[k] for link, each in request.motions.items()} for k in range(count)]
    for index, picture in enumerate(moved_pictures(request.model, motions, window, renderer, request.size_px)):
        paths.append(folder / f"{index:03d}.png")
        save_png(picture, paths[-1])
    return paths


def draw_strip(
    model: Model, mechanism: Mechanism, window: vtkRenderWindow, renderer: vtkRenderer, size_px: int
) -> Image.Image:
    """The object with all its joints opened by 0, 50 and 100 %, side by side; the renderer is left empty."""
    joints = movable_joints(mechanism)
    positions = [opened(joints, share) for share in STRIP_SHARES]
    strip = Image.new("RGB", (len(positions) * size_px, size_px), (BACKGROUND_SRGB,) * 3)
    drawn, font = ImageDraw.Draw(strip), ImageFont.load_default(_LABEL_PX)
    for index, picture in enumerate(posed_pictures(model, positions, window, renderer, size_px)):
        strip.paste(picture, (index * size_px, 0))
        place = (index * size_px + _LABEL_AT[0], _LABEL_AT[1])
        drawn.text(place, f"{100 * STRIP_SHARES[index]:.0f} %", fill=_LABEL_SRGB, font=font)
    return strip


def posed_pictures(
    model: Model,
    positions: Sequence[Mapping[str, float]],
    window: vtkRenderWindow,
    renderer: vtkRenderer,
    size_px: int,
) -> Iterator[Image.Image]:
    """One picture for each of `positions`. Raises ValueError for a model without mechanism."""
    if model.mechanism is None:
        raise ValueError("the model has no mechanism")
    motions = [link_motions(model.mechanism, given) for given in positions]
    yield from moved_pictures(model, motions, window, renderer, size_px)


def moved_pictures(
    model: Model,
    motions: Sequence[Mapping[str, FloatArray]],
    window: vtkRenderWindow,
    renderer: vtkRenderer,
    size_px: int,
) -> Iterator[Image.Image]:
    """One picture for each of `motions` (at least one): (4, 4) of the asset frame by the name of a link."""
    scene = _PosedScene(model, swept_frame(model, motions), window, renderer)
    view = _telling_view(scene, [motions[0], motions[len(motions) // 2], motions[-1]])
    for motion in motions:
        yield scene.picture(motion, view, size_px)
    renderer.RemoveAllViewProps()


def _telling_view(scene: _PosedScene, motions: Sequence[Mapping[str, FloatArray]]) -> CameraView:
    """The hero view, or that from another corner if the motions change far more of the picture there.

    Many doors open away from the hero view, because nothing says where the front of their object is.
    """
    corners = [replace(HERO_VIEW, azimuth_deg=HERO_VIEW.azimuth_deg + turn) for turn in (0.0, 90.0, 180.0, 270.0)]
    changed = []
    for view in corners:
        seen = [np.asarray(scene.picture(motion, view, _TRIAL_PX), dtype=np.int64) for motion in motions]
        steps = (np.abs(b - a).max(axis=2) for a, b in itertools.pairwise(seen))
        changed.append(sum(int((step > _VISIBLE_STEP).sum()) for step in steps))
    best = int(np.argmax(changed))
    return corners[best] if changed[best] > _FAR_MORE * changed[0] else HERO_VIEW


class _PosedScene:
    """The links of a model as actors of a renderer, drawn in any pose of theirs."""

    def __init__(self, model: Model, frame: AnnotationFrame, window: vtkRenderWindow, renderer: vtkRenderer) -> None:
        self._frame, self._window, self._renderer = frame, window, renderer
        self._links = _drawn_links(model, frame, TextureSet(model.textures))
        renderer.RemoveAllViewProps()
        visuals = [visual for _, of_link in self._links.values() for visual in of_link]
        for visual in visuals:
            renderer.AddActor(visual)
        if any(visual.GetForceTranslucent() for visual in visuals):
            enable_depth_peeling(renderer)

    def picture(self, motion: Mapping[str, FloatArray], view: CameraView, size_px: int) -> Image.Image:
        """The object with its links moved by `motion`, (4, 4) of the asset frame by name."""
        frame, posed = self._frame, list[ShadedSurface]()
        for name, (parts, visuals) in self._links.items():
            # The same motion in the annotation frame, which is shifted and scaled, but not turned.
            M_N = pose(motion[name][:3, :3], frame.from_asset(apply(motion[name], frame.centre_m[None]))[0])
            for visual in visuals:
                visual.SetUserMatrix(_vtk_matrix(M_N))
            for part in parts:
                points = apply(M_N, part.points.reshape(-1, 3).astype(np.float64)).reshape(-1, 3, 3)
                posed.append(replace(part, points=points.astype(np.float32)))
        ground = floor(surface_samples(tuple(posed)), -frame.extent[2] / 2.0)
        self._renderer.AddActor(ground)
        picture = take_picture(self._window, self._renderer, camera(view, frame.extent), size_px)
        self._renderer.RemoveActor(ground)
        return picture


def swept_frame(model: Model, motions: Sequence[Mapping[str, FloatArray]]) -> AnnotationFrame:
    """The annotation frame of the box that holds the finite points of the model in all poses."""
    points = [(mesh.link, used_points(mesh)) for mesh in model.meshes]
    return frame_around(apply(motion[link], of_mesh) for link, of_mesh in points for motion in motions)


def _drawn_links(
    model: Model, frame: AnnotationFrame, textures: TextureSet
) -> dict[str, tuple[tuple[ShadedSurface, ...], list[vtkActor]]]:
    """Surfaces at rest and their actors by the name of their link."""
    drawn = {}
    for name in dict.fromkeys(mesh.link for mesh in model.meshes):
        meshes = tuple(mesh for mesh in model.meshes if mesh.link == name)
        parts = tuple(part for part in surfaces(replace(model, meshes=meshes), frame) if len(part.points))
        drawn[name] = parts, [actor(part, textures) for part in parts]
    return drawn


def _vtk_matrix(X: FloatArray) -> vtkMatrix4x4:
    matrix = vtkMatrix4x4()
    matrix.DeepCopy(X.ravel().tolist())
    return matrix
