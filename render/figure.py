"""One look for all drawn pictures: no display, no dates, no frame where nothing is read off."""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_DPI = 110


def figure(width: float = 8.0, height: float = 4.2) -> Figure:
    """An empty figure, inches."""
    made = Figure(figsize=(width, height), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(made)
    return made


def tidy(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Labels, and no frame where nothing is read off."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e4e7eb", linewidth=0.8)
    axes.set_axisbelow(True)


def png(made: Figure) -> bytes:
    """The figure as PNG, without program names or dates."""
    buffer = io.BytesIO()
    made.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()
