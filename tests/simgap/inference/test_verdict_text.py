"""Texts of a verdict: one gain everywhere, and no interval with a single test trial."""

import numpy as np
import pytest

from schemas.sim_gap.extension import Estimate, Place
from schemas.sim_gap.report import AmbiguousGroup, Gain, NamedEffect
from simgap.inference.verdict_text import share, statement


def gain(reduction: float, low: float) -> Gain:
    """Of one view; all else is of no matter here."""
    return Gain(
        view="short_horizon",
        horizon_s=0.08,
        metric="rms error in noise levels",
        heldout_before=4.0,
        heldout_after=4.0 * (1.0 - reduction),
        reduction=reduction,
        ci95=(low, 0.7),
        noise_floor=1.0,
        gap_closed=0.5,
    )


def friction(confidence: float) -> NamedEffect:
    return NamedEffect(
        name="contact.friction",
        where=Place(pair="body-support"),
        confidence=confidence,
        routes={"heldout": True, "direct": True},
        parameters={"mu": Estimate(value=0.2, unit="1", ci95=(0.1, 0.3))},
    )


@pytest.mark.parametrize(
    ("low", "said"), [(0.3, "50% (30% to 70%)"), (-0.1, "50% (-10% to 70%)"), (-np.inf, "50% (one trial: no interval)")]
)
def test_a_share_carries_its_interval_where_there_is_one(low, said):
    assert share(0.5, (low, 0.7)) == said


def test_an_error_far_above_the_noise_is_told_where_nothing_is_named():
    words = statement([gain(0.0, 0.0)], [], [], False)
    assert "4 times the noise" in words


@pytest.mark.parametrize(("value", "said"), [(0.004, "0.4%"), (-0.004, "-0.4%"), (-1e-5, "0.0%"), (0.013, "1%")])
def test_small_shares_keep_a_digit_and_nothing_has_no_sign(value, said):
    assert share(value, (-np.inf, 1.0)).split(" (")[0] == said


@pytest.mark.parametrize("after", [1.0, 4.0])
def test_a_single_trial_that_finds_nothing_says_so(after):
    alone = gain(0.0, -np.inf).model_copy(update={"heldout_after": after})
    assert "a single trial judges that" in statement([alone], [], [], False)
    assert "single" not in statement([alone.model_copy(update={"ci95": (-0.1, 0.1)})], [], [], False)


def test_an_error_that_is_no_number_is_not_called_fine():
    unknown = gain(0.0, -0.1).model_copy(update={"heldout_after": float("nan")})
    assert not statement([unknown], [], [], False).startswith("No effect is needed")


def test_the_sentence_tells_the_gain_of_the_report():
    words = statement([gain(0.5, 0.3)], [friction(1.0)], [], False)
    figures = "50% (30% to 70%) less held-out error over roll-outs of 0.08 s"
    assert words == f"Add contact.friction at body-support (mu = 0.2): {figures}."


def test_every_headline_with_effects_quotes_short_and_whole_roll_outs():
    """Half an error less over 80 ms may be nothing over whole trials: both are said, whatever the status."""
    whole = gain(0.9, 0.8).model_copy(update={"view": "full_rollout", "horizon_s": 0.0, "ci95": (0.8, 0.95)})
    gains = [gain(0.5, 0.3), whole]
    figures = "50% (30% to 70%) less held-out error over roll-outs of 0.08 s and 90% (80% to 95%) over whole roll-outs"
    alone = AmbiguousGroup(effects=("contact.friction",), experiment="slide it")
    pair = AmbiguousGroup(effects=("contact.friction", "body.mass"), experiment="weigh it")
    assert figures in statement(gains, [friction(1.0)], [], False)
    assert figures in statement(gains, [friction(0.4)], [alone], False)
    assert figures in statement(gains, [friction(0.4)], [pair], False)


def test_events_have_one_figure():
    both = [gain(0.5, 0.3).model_copy(update={"horizon_s": 0.0})] * 2
    assert statement(both, [friction(1.0)], [], False).endswith("50% (30% to 70%) less held-out error.")


def test_a_name_that_takes_no_error_away_is_not_sold_as_if_it_did():
    words = statement([gain(-0.08, -0.3)], [friction(1.0)], [], False)
    assert words.endswith("no less held-out error over roll-outs of 0.08 s, -8% (-30% to 70%).")


@pytest.mark.parametrize(("highest", "told"), [(-0.04, True), (0.02, False)])
def test_whole_roll_outs_that_surely_get_worse_are_told(highest, told):
    whole = gain(-0.11, -0.23).model_copy(update={"view": "full_rollout", "ci95": (-0.23, highest)})
    words = statement([gain(0.07, 0.01), whole], [friction(1.0)], [], False)
    assert ("whole roll-outs get worse, -11% (-23% to -4%)" in words) == told


def test_what_is_in_doubt_is_told_where_its_gain_is_counted():
    doubt = AmbiguousGroup(effects=("body.inertia",), experiment="spin it")
    words = statement([gain(0.5, 0.3)], [friction(1.0), friction(0.4)], [doubt], True)
    assert words.endswith("roll-outs of 0.08 s, with what is in doubt beside it; something structured is left.")
