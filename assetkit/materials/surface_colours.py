"""Colours of an object: shares of the basic colour terms over its visible surface, by area of the base colours."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from assetkit.materials.colour_names import basic_terms
from assetkit.materials.surface_samples import base_colours, pixels_of, sample_surface
from schemas.model import Model

MIN_AREA_SHARE = 0.05  # Colours of less of the surface are labels and seams.
_COLOUR_SAMPLES = 4000  # per mesh, faces drawn evenly by area; a share is then known to about a percent.


def surface_colours(model: Model) -> dict[str, float]:
    """Basic colour terms with their share of the surface that has a stated colour, the largest first.

    {} when nothing states a colour: no material, or only one with our own grey. Lighting, emission and metal are left
    out of account: it is the colour that the material states.
    """
    pixels = pixels_of(model)
    area_of: dict[str, float] = defaultdict(float)
    for mesh in model.meshes:
        material = None if mesh.material is None else model.materials[mesh.material]
        points = sample_surface(mesh, _COLOUR_SAMPLES)
        colours = base_colours(mesh, material, points, pixels)
        if colours is None:
            continue
        terms, counts = np.unique(basic_terms(colours), return_counts=True)
        for term, count in zip(terms, counts, strict=True):
            area_of[str(term)] += points.area * float(count) / len(points.faces)
    total = sum(area_of.values())
    shares = {term: round(area / total, 3) for term, area in area_of.items() if area >= MIN_AREA_SHARE * total > 0.0}
    return dict(sorted(shares.items(), key=lambda pair: (-pair[1], pair[0])))
