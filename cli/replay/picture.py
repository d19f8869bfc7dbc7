"""An episode from above and from the side: supports, what is swept over them, what was put in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from render.figure import figure, png
from replay.augmentation import REFERENCE_TOP_M, PreparedEpisode
from replay.envelope.envelope import Envelope

_BODY = ("#4c78a8", "#f58518", "#54a24b", "#e45756", "#72b7b2", "#b279a2", "#ff9da6", "#9d755d", "#eeca3b", "#8c8c8c")
_SWEPT, _FREE, _PUT = "#f3c4bd", "#d5ead8", "#3d5a80"


def picture(prepared: PreparedEpisode, put: Sequence[tuple[str, BaseGeometry]] = ()) -> bytes:
    """PNG. Left from above: free (green) and taken (red) parts of supports up to 0.1 m, and objects put in, by name and
    outline in W. Right from the side: the middle lines of the envelope's capsules, a colour for each body.
    """
    sheet = figure(11.0, 4.6)
    above, side = sheet.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.1]})
    for site in prepared.sites:
        support = site.free_space.support
        _fill(above, support.area, _SWEPT, "#b0563f")
        _fill(above, site.free_space.free(REFERENCE_TOP_M), _FREE, "none")
        x, y = support.area.centroid.coords[0]
        above.text(x, support.area.bounds[3], support.name, ha="center", va="bottom", fontsize=8, color="#555555")
    for name, outline in put:
        _fill(above, outline, _PUT, "white", 0.85)
        above.text(outline.centroid.x, outline.bounds[3], name, ha="center", va="bottom", fontsize=7, color=_PUT)
    above.set_title(f"free up to {REFERENCE_TOP_M} m (green), swept or taken (red)", loc="left", fontsize=10)
    _side(side, prepared.envelope)
    for axes, x, y in ((above, "x (m)", "y (m)"), (side, "x (m)", "z (m)")):
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_xlabel(x)
        axes.set_ylabel(y)
        axes.spines[["top", "right"]].set_visible(False)
    return png(sheet)


def _side(axes: Axes, envelope: Envelope) -> None:
    for number, name in enumerate(envelope.bodies):
        mine = envelope.body == number
        lines = np.stack([envelope.start_W[mine][:, [0, 2]], envelope.end_W[mine][:, [0, 2]]], axis=1)
        colour = _BODY[number % len(_BODY)]
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=0.5, alpha=0.5))
        axes.plot([], [], color=colour, label=name)
    axes.set_title("paths of the balls that hold each body", loc="left", fontsize=10)
    axes.legend(fontsize=6, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _fill(axes: Axes, area: BaseGeometry, face: str, edge: str, alpha: float = 1.0) -> None:
    for part in shapely.get_parts(area):
        if isinstance(part, shapely.Polygon) and not part.is_empty:
            turned = orient(part)  # holes run the other way round, so that they stay open
            rings = [Path(np.asarray(ring.coords)) for ring in (turned.exterior, *turned.interiors)]
            whole = Path.make_compound_path(*rings)
            axes.add_patch(PathPatch(whole, facecolor=face, edgecolor=edge, linewidth=0.8, alpha=alpha))
