"""Picture of the ablation: held-out rms error as declared, refitted, with each effect added, and of noise."""

from __future__ import annotations

from collections.abc import Sequence

from render.figure import figure, png, style_axes
from schemas.sim_gap.report import Rival
from simgap.report.pictures.colours import DECLARED, EXTENDED, NOISE

_WORDS = {"declared": "model as declared", "null_refit": "declared numbers refitted", "noise_floor": "noise alone"}


def ablation(steps: Sequence[Rival]) -> bytes:
    """PNG of horizontal bars, one per step, in noise levels (logarithmic when they span more than a decade)."""
    canvas = figure(8.0, 1.2 + 0.5 * len(steps))
    axes = canvas.subplots()
    values = [max(s.heldout, 1e-3) for s in steps]
    colours = [NOISE if s.name == "noise_floor" else DECLARED if s.name in _WORDS else EXTENDED for s in steps]
    names = [_WORDS.get(s.name, f"+ {s.name}") for s in steps]
    axes.barh(range(len(steps)), values, color=colours, height=0.62)
    axes.set_yticks(range(len(steps)), names)
    axes.invert_yaxis()
    wide = max(values) > 20.0 * min(values)
    if wide:
        axes.set_xscale("log")
        axes.set_xlim(0.5 * min(values), 2.5 * max(values))
    else:
        axes.set_xlim(0.0, 1.15 * max(values))
    for row, value in enumerate(values):
        axes.text(value * 1.05 if wide else value + 0.01 * max(values), row, f"{value:.3g}", va="center", fontsize=9)
    style_axes(axes, "held-out rms error over short horizons (1 = noise)", "", "Where the error goes")
    axes.grid(visible=False)
    return png(canvas)
