"""Signs of light in a base colour: its brightness follows the direction of the surface, everywhere in the same way.

Irradiance from distant light is, to a percent or two, a polynomial of second degree in the normal (Ramamoorthi and
Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps). Within one small place and one chromaticity
the paint is taken to be the same; what brightness is left there is fitted by one such polynomial for the whole object,
and the fit is judged in places that it has not seen. Paint that merely differs between places or faces fits in some and
fails in others; light fits in all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assetkit.materials.surface_samples import base_colours, pixels_of, sample_surface
from geom.mesh.corner_normals import corner_normals
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, inferred
from schemas.model import Model

METHOD: Final = (
    "share of the variance of log brightness within places that a quadratic of the normal predicts elsewhere"
)

_DIRECTION_STEP: Final = 0.2  # of a component of a unit normal, about 11 degrees


@dataclass(frozen=True)
class LightingPolicy:
    """Bounds of the test. Fixed on balls painted with and without light (tests), then checked on real assets.

    samples           points per object; the share is then known to about a percent.
    places            cubes along the longest side of the object; a place is one of them.
    chroma_step       width of a class of chromaticity, in r / (r + g + b): above the noise of JPEG.
    darkest, brightest  linear brightness outside which texels are clipped or too coarse to compare.
    least_directions  effective number of directions of the surface: on boxes, trays and other shapes of few faces,
                      paint that differs from face to face looks like light.
    least_points      per place; least_places  per object.
    suspected         share of the variance from which light is suspected, if places of `agreeing` of the points agree.
    """

    samples: int = 20_000
    places: int = 3
    chroma_step: float = 0.03
    darkest: float = 0.004
    brightest: float = 0.95
    least_directions: float = 16.0
    least_points: int = 20
    least_places: int = 6
    folds: int = 5
    suspected: float = 0.3
    agreeing: float = 0.75


POLICY: Final = LightingPolicy()


def baked_lighting(model: Model, policy: LightingPolicy = POLICY) -> Evidence[float] | None:
    """The share (0..1) of the base colour's variation that light explains; None where the surface cannot show it.

    The confidence is the share of places, by points, in which the prediction made without them has the right sign.
    """
    points, normals, colours = _samples(model, policy.samples)
    brightness = colours @ np.array([0.2126, 0.7152, 0.0722])
    usable = (brightness > policy.darkest) & (brightness < policy.brightest)
    points, normals, colours, brightness = points[usable], normals[usable], colours[usable], brightness[usable]
    if len(points) < policy.least_points * policy.least_places:
        return None
    groups, places = _groups(points, colours, policy)
    counts = np.bincount(groups)
    seen = counts[groups] >= policy.least_points
    groups, places, normals, brightness = groups[seen], places[seen], normals[seen], brightness[seen]
    if len(np.unique(places)) < policy.least_places or directions(normals) < policy.least_directions:
        return None
    terms = _within(_quadratic(normals), groups)
    values = _within(np.log(brightness)[:, None], groups)[:, 0]
    predicted = _predicted_elsewhere(terms, values, places, policy.folds)
    total = float(values @ values)
    if total <= 1e-9 * len(values):
        return None
    share = max(0.0, 1.0 - float(((values - predicted) ** 2).sum()) / total)
    agreeing = _agreement(values, predicted, places)
    return inferred(round(share, 3), METHOD, round(agreeing, 3))


def suspicion(evidence: Evidence[float] | None, policy: LightingPolicy = POLICY) -> tuple[Diagnostic, ...]:
    """`asset/baked-lighting-suspected` from the policy's shares on; nothing where the surface could not show it."""
    if evidence is None or evidence.value < policy.suspected or evidence.confidence < policy.agreeing:
        return ()
    headline = f"{evidence.value:.0%} of the variation of the base colour follows the direction of the surface"
    return (finding("asset/baked-lighting-suspected", headline, value=evidence.value, bound=policy.suspected),)


def directions(normals: FloatArray) -> float:
    """The effective number of directions of unit normals (n, 3), at 11 degrees: the inverse Simpson index.

    Few large faces count as many as they are, however many small ones lie between them.
    """
    _, counts = np.unique(np.round(normals / _DIRECTION_STEP), axis=0, return_counts=True)
    shares = counts / max(len(normals), 1)
    return float(1.0 / np.sum(shares**2)) if len(normals) else 0.0


def _samples(model: Model, most: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (n, 3), unit normals (n, 3) and linear base colours (n, 3) of the surfaces with a base-colour texture."""
    pixels = pixels_of(model)
    textured = [
        mesh
        for mesh in model.meshes
        if mesh.material is not None and model.materials[mesh.material].base_color_texture is not None
    ]
    areas = [sample_surface(mesh, 1).area for mesh in textured]
    points, normals, colours = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros((0, 3))]
    for mesh, area in zip(textured, areas, strict=True):
        samples = sample_surface(mesh, int(most * area / sum(areas)) if sum(areas) > 0.0 else 0)
        seen = base_colours(mesh, model.materials[mesh.material or 0], samples, pixels)
        if seen is None or not len(samples.faces):
            continue
        corners = mesh.points[mesh.triangles[samples.faces]]
        stated = corner_normals(mesh.points, mesh.triangles) if mesh.normals is None else mesh.normals
        turned = np.einsum("nk,nkc->nc", samples.weights, stated[samples.faces])
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        sound = (length[:, 0] > 1e-6) & np.isfinite(turned).all(axis=1)
        points.append(np.einsum("nk,nkc->nc", samples.weights, corners)[sound])
        normals.append((turned / np.where(length > 1e-6, length, 1.0))[sound])
        colours.append(seen[sound])
    return np.concatenate(points), np.concatenate(normals), np.concatenate(colours)


def _groups(points: FloatArray, colours: FloatArray, policy: LightingPolicy) -> tuple[IntArray, IntArray]:
    """(n,) group of one place and chromaticity, (n,) place, of each point."""
    low, high = points.min(axis=0), points.max(axis=0)
    cube = np.floor((points - low) / max(float((high - low).max()), 1e-9) * policy.places).clip(0, policy.places - 1)
    chroma = np.floor(colours[:, :2] / np.maximum(colours.sum(axis=1, keepdims=True), 1e-9) / policy.chroma_step)
    _, places = np.unique(cube, axis=0, return_inverse=True)
    _, groups = np.unique(np.column_stack([cube, chroma]), axis=0, return_inverse=True)
    return groups.reshape(-1), places.reshape(-1)


def _quadratic(n: FloatArray) -> FloatArray:
    """(n, 8) the spherical harmonics of degrees 1 and 2 of unit normals, up to their factors."""
    x, y, z = n.T
    return np.stack([x, y, z, x * y, y * z, x * z, 3.0 * z * z - 1.0, x * x - y * y], axis=1)


def _within(values: FloatArray, groups: IntArray) -> FloatArray:
    """(n, k) values less the mean of their group."""
    counts = np.bincount(groups)
    means = np.stack(
        [np.bincount(groups, values[:, k]) / np.maximum(counts, 1) for k in range(values.shape[1])], axis=1
    )
    return values - means[groups]


def _predicted_elsewhere(terms: FloatArray, values: FloatArray, places: IntArray, folds: int) -> FloatArray:
    """(n,) the values that a fit to the other folds predicts; whole places are left out together."""
    predicted = np.zeros_like(values)
    ridge = 1e-6 * len(values) * np.eye(terms.shape[1])
    for fold in range(folds):
        out = places % folds == fold
        a, b = terms[~out], values[~out]
        predicted[out] = terms[out] @ np.linalg.solve(a.T @ a + ridge, a.T @ b)
    return predicted


def _agreement(values: FloatArray, predicted: FloatArray, places: IntArray) -> float:
    """The share of points in places where prediction and value vary together."""
    together = np.bincount(places, values * predicted)
    return float(np.mean(together[places] > 0.0))
