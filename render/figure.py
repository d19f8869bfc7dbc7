"""Matplotlib figures in one style: no display, no metadata dates, no frame on sides without a scale."""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_DPI = 110


def figure(width: float = 8.0, height: float = 4.2) -> Figure:
    """An empty figure; width and height in inches."""
    empty = Figure(figsize=(width, height), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(empty)
    return empty


def style_axes(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Set axis labels and title; hide the frame on sides without a scale."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e4e7eb", linewidth=0.8)
    axes.set_axisbelow(True)


def png(drawn: Figure) -> bytes:
    """The figure as PNG, without program names or dates."""
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()
