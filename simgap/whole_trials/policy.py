"""All thresholds of the inference on whole trials, each with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """Thresholds; probabilities and shares have unit 1.

    alpha             chance of a false effect per step of the search, over all candidates together (Bonferroni).
    rejection_alpha   chance below which a model leaves the confidence set: the usual 5 % of a 95 % set.
    least_gain        share of the held-out deviance that an effect must take off. Two integrators of one law differ by
                      up to 1 % on the control recordings of `docs/benchmarks-simgap.md`.
    explained         share of the null model's excess over noise that may stay before a name is doubted. 2 % of
                      the mean square are 86 % less error: right laws leave less on the foreign recordings (cases 1
                      and 3: 1 and 0.2 %), wrong ones more (cases 7 and 15: 45 and 4 %).
    noise_excess      excess of the mean square error over that of noise that counts as none: the noise of 20 trials
                      is itself known to some per cent (chi-squared, 500 rows each).
    most_effects      effects of one model; three causes at once are the most that the suite asks for.
    beam              models that the next step extends.
    full_fits         candidates per extended model that are fitted to the end, best score first.
    promising         share of the best score that a candidate needs to be fitted to the end.
    iterations        steps of Gauss and Newton of one fit; they end earlier at `least_step` of deviance.
    contrast          error of a reading in a slice over that of one outside, below which (at its lower 95 % bound over
                      trials) a report does not call the slice the place of the error: at 1.25, 40 % of the readings
                      hold at least 45 % of the error.
    """

    alpha: float = 0.05
    rejection_alpha: float = 0.05
    least_gain: float = 0.02
    explained: float = 0.02
    noise_excess: float = 0.1
    most_effects: int = 3
    beam: int = 2
    full_fits: int = 8
    promising: float = 0.3
    iterations: int = 12
    least_step: float = 0.5
    contrast: float = 1.25


POLICY = Policy()
