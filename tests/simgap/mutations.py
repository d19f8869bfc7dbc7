"""`python -m tests.simgap.mutations`: breaks the finder on purpose, one way after another; the tests must notice each.

Each mutation is applied in a process of its own, in which pytest runs `GUARDS`: as a plugin this module reads the
mutation's name from the environment. The command fails if some mutation passes all tests.
"""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any
from unittest import mock

import numpy as np

from simgap.inference import confirmation, fit, verdict
from simgap.inference.decision import decide
from simgap.problem import DirectEstimate
from simgap.whole_trials import check, confidence_set, find, fit_model, judge, ladder, search_models

ENVIRONMENT = "MANA_MUTATION"
GUARDS = ("tests/simgap/whole_trials/test_check.py", "tests/simgap/whole_trials/test_judge.py")
TOSS_GUARDS = ("tests/simgap/kinds/free_body/test_guard_cases.py",)


def _second_route_off() -> None:
    def agrees(problem: Any, term: Any, widths: Any, others: Any, trials: Any) -> Any:
        return problem.direct(term.candidate, others, trials), decide([])

    _patch(judge, "_direct_agreement", agrees)


def _shape_test_off() -> None:
    _patch(judge, "shape_of", lambda *inputs: decide([]))


def _shape_always_hidden() -> None:
    _patch(judge, "structures", lambda leftovers, alpha: ())


def _numerics_off() -> None:
    def as_begun(system: Any, model: Any, starts: Any, policy: Any, **options: Any) -> Any:
        return fit_model.fit_at(system, model, starts)

    for module in (ladder, search_models, fit_model):
        _patch(module, "fit_model", as_begun)


def _never_a_group() -> None:
    _patch(confidence_set.ConfidenceSet, "alternatives", lambda self, term: ())


def _bic_only() -> None:
    def enters(null: Any, before: Any, after: Any, candidates: int, policy: Any) -> Any:
        penalty = len(after.fit.effects[-1].values) * np.log(after.fit.rows.sum())
        lead = before.fit.losses.sum() - after.fit.losses.sum() - penalty
        return decide([(search_models.Reason.TOO_SMALL, search_models.criterion("delta BIC", float(lead), ">", 0.0))])

    _patch(search_models, "_enters", enters)
    _explained_always()


def _explained_always() -> None:
    plain = check.check_whole_trials

    def kept(*inputs: Any) -> Any:
        return dataclasses.replace(plain(*inputs), explains=decide([]))

    _patch(check, "check_whole_trials", kept)


def _test_trials_never_asked() -> None:
    _patch(check, "confirmed", lambda system, search, policy: search)
    _patch(find, "confirmed", lambda system, search, policy: search)


def _intervals_a_third_as_wide() -> None:
    plain = fit_model.half_widths

    def narrow(fit: Any, quantile: float) -> Any:
        return plain(fit, quantile / 3.0)

    for module in (judge, fit_model):
        _patch(module, "half_widths", narrow)


def _random_name() -> None:
    def reversed_order(self: Any) -> Any:
        return -float(self.held_out.sum()), tuple(sorted(self.fit.keys))

    _patch(search_models.FittedModel, "order", property(reversed_order))


def _always_doubt() -> None:
    _patch(judge, "_confidence", lambda doubts, direct, policy: 0.5)


def _toss_second_route_off() -> None:
    def agrees(problem: Any, fitted: Any, term: Any, widths: Any, others: Any, trials: Any, alone: Any) -> Any:
        errors = {name: width / 1.96 for name, width in widths.items()}
        return DirectEstimate(dict(term.values), errors, 0.0, len(trials)), decide([])

    _patch(verdict, "direct_agreement", agrees)
    _patch(verdict, "exceeds_method_bias", lambda *inputs: decide([]))


def _toss_never_a_group() -> None:
    _patch(verdict, "_mimics", lambda *inputs: [])
    _patch(verdict, "_preferred_by_direct", lambda *inputs: [])


def _toss_test_trials_never_asked() -> None:
    _patch(confirmation, "is_confirmed", lambda evidence: decide([]))


def _toss_intervals_a_third_as_wide() -> None:
    plain = fit.half_widths
    _patch(fit, "half_widths", lambda solution: plain(solution) / 3.0)
    _patch(verdict, "distance_to_alternatives", lambda term, widths, direct, mimics: verdict.symmetric(widths))


def _toss_always_doubt() -> None:
    _patch(verdict, "_confidence", lambda p_adjusted, evidence, shared: 0.5)


MUTATIONS: dict[str, Callable[[], None]] = {
    "second route off": _second_route_off,
    "shape test off": _shape_test_off,
    "no structure ever": _shape_always_hidden,
    "numerics off": _numerics_off,
    "never a group": _never_a_group,
    "BIC only": _bic_only,
    "explained always": _explained_always,
    "test trials never asked": _test_trials_never_asked,
    "intervals a third as wide": _intervals_a_third_as_wide,
    "random name": _random_name,
    "always doubt": _always_doubt,
}
# Tosses have a search of their own, over windows; it recovers from a screening in another order.
TOSS_MUTATIONS: dict[str, Callable[[], None]] = {
    "tosses: second route off": _toss_second_route_off,
    "tosses: never a group": _toss_never_a_group,
    "tosses: test trials never asked": _toss_test_trials_never_asked,
    "tosses: intervals a third as wide": _toss_intervals_a_third_as_wide,
    "tosses: always doubt": _toss_always_doubt,
}


def _patch(owner: Any, name: str, value: Any) -> None:
    """Replaces an attribute that must exist, for the rest of the process."""
    mock.patch.object(owner, name, value).start()


def pytest_configure() -> None:
    """Applies the mutation that the environment names, before tests import what it breaks."""
    if name := os.environ.get(ENVIRONMENT):
        (MUTATIONS | TOSS_MUTATIONS)[name]()


def unnoticed() -> list[str]:
    """Mutations that pass all guards; a line for each as it ends."""
    out = []
    for name in (*MUTATIONS, *TOSS_MUTATIONS):
        guards = TOSS_GUARDS if name in TOSS_MUTATIONS else GUARDS
        plugins = ["-p", "no:cacheprovider", "-p", __spec__.name]
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-m", "long or not long", *plugins, *guards]
        done = subprocess.run(
            command, env=os.environ | {ENVIRONMENT: name}, capture_output=True, text=True, check=False
        )
        first = next((line for line in done.stdout.splitlines() if line.startswith("FAILED")), "")
        print(f"{name:34} {'noticed' if done.returncode == 1 else 'NOT NOTICED'}  {first[:110]}", flush=True)
        if done.returncode != 1:
            out.append(name)
    return out


if __name__ == "__main__":
    sys.exit(1 if unnoticed() else 0)
