"""All thresholds of the inference on whole trials, each with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """Thresholds; probabilities and shares have unit 1.

    alpha             chance of a false effect per step of the search, over all candidates together (Bonferroni).
    rejection_alpha   chance below which a model leaves the confidence set: one in a thousand, as a wrong name is worse
                      than a group.
    least_gain        loss per row that an effect must take off, in units of that of noise. Two integrators of one law
                      differ by up to 1 % on the control recordings of `docs/benchmarks-simgap.md`.
    least_lead        loss per row by which a rejected model must be worse; a quarter of that.
    explained         share of the null model's excess over noise that may stay before a name is doubted: 1.7 % of the
                      amplitude, twice what two integrators of one law differ by.
    noise_excess      excess of the mean square error over that of noise that counts as none, beside so many
    noise_errors      standard errors of the noise level: 2 / sqrt(n) of its square for n rows, from second differences.
    largest_excess    excess of a trial beyond which it counts no more.
    least_share       share of the null model's loss per row that an effect must take off: what a law lacks shows beside
                      a large effect, not beside a small one.
    most_effects      effects of one model; three causes at once are the most that the suite hides.
    beam              models that the next step extends.
    least_score       loss that a linear step must take off: less is noise (99.5 % of chi-squared with one degree).
    idle              loss that a threshold may cost and count as one that no trial reaches.
    twin              times what is noticed, from which on two effects count as one on these recordings: effects ten
                      times as strong as what is noticed are rare.
    full_fits         candidates per extended model that are fitted to the end, best score first.
    promising         share of the best score that a candidate needs to be fitted to the end; the `fewest` best of each
                      rung are in any case, because a score is that of a linear step.
    pieces            into which trials are cut, on the rungs of the ladder before whole trials.
    begins            rungs from which a candidate's fit climbs, those with its best scores.
    rung_iterations   steps of Gauss and Newton on each rung, and `iterations` at the end for so many `polished` models;
                      they end earlier at `least_step` of loss.
    shape_share       share, in squares, that a law must explain of what repeats in the balance of forces: at 0.95 what
                      no values explain has a quarter of the amplitude of what the law explains, more than engines and
                      believed numbers (5 %) make of a law.
    contrast          error of a reading in a slice over that of one outside, below which (at its lower 95 % bound over
                      trials) a report does not call the slice the place of the error: at 1.25, 40 % of the readings
                      hold at least 45 % of the error.
    """

    alpha: float = 0.05
    rejection_alpha: float = 0.001
    least_gain: float = 0.02
    least_lead: float = 0.005
    explained: float = 3e-4
    noise_excess: float = 0.05
    noise_errors: float = 3.0
    largest_excess: float = 1e8
    least_share: float = 0.02
    most_effects: int = 3
    beam: int = 2
    least_score: float = 8.0
    idle: float = 0.5
    twin: float = 10.0
    full_fits: int = 9
    promising: float = 0.2
    fewest: int = 3
    pieces: tuple[int, ...] = (16, 4)
    begins: int = 2
    rung_iterations: int = 4
    polished: int = 6
    iterations: int = 12
    least_step: float = 0.5
    shape_share: float = 0.95
    contrast: float = 1.25


POLICY = Policy()
