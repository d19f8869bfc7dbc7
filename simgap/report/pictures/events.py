"""Picture of simulated against measured outcomes of events, one point each, SI; a right model is on the diagonal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from render.figure import figure, png, style_axes
from schemas.arrays import FloatArray
from simgap.problem import EventProblem, Model
from simgap.report.pictures.colours import DECLARED, EXTENDED, MEASURED

_SHOWN_SPREADS = 4.0  # robust spreads of the readings that are shown around their median


def outcomes(problem: EventProblem, trials: Sequence[str], extension: Model) -> bytes:
    """PNG of the channel where the extension (or, with none, the declared model) differs most from the other."""
    measured = np.concatenate(problem.readings(trials))
    floor = np.maximum(problem.noise_floor(trials, "short_horizon"), 1e-12)
    models: list[tuple[Model, str, str]] = [((), DECLARED, "as declared")]
    models += [(extension, EXTENDED, "with the extension")] if extension else []
    errors = [np.concatenate(problem.residuals(m, trials, "short_horizon")) for m, _, _ in models]
    sizes = [_size(e / floor) for e in errors]
    channel = int(np.argmax(sizes[0] - sizes[-1] if extension else sizes[0]))
    name = problem.channels()[channel]
    canvas = figure(8.0, 4.6)
    panels = canvas.subplots(1, len(models), sharex=True, sharey=True, squeeze=False)[0]
    truth = measured[:, channel]
    low, high = _window(truth)
    for axes, (_, colour, words), error in zip(panels, models, errors, strict=True):
        axes.plot([low, high], [low, high], color=MEASURED, linewidth=1.0)
        axes.plot(truth, truth + error[:, channel], ".", color=colour, markersize=4, alpha=0.6)
        axes.set_xlim(low, high)
        axes.set_ylim(low, high)
        axes.locator_params(axis="x", nbins=5)
        style_axes(
            axes, f"{name}, measured", f"{name}, simulated" if axes is panels[0] else "", f"Held-out events, {words}"
        )
    return png(canvas)


def _size(errors: FloatArray) -> FloatArray:
    return np.nanmean(np.log1p(errors**2), axis=0)


def _window(values: FloatArray) -> tuple[float, float]:
    middle = float(np.nanmedian(values))
    spread = 1.4826 * float(np.nanmedian(np.abs(values - middle))) + 1e-9
    low = max(middle - _SHOWN_SPREADS * spread, float(np.nanmin(values)))
    high = min(middle + _SHOWN_SPREADS * spread, float(np.nanmax(values)))
    room = 0.15 * max(high - low, 1e-9)
    return low - room, high + room
