"""Scores a verdict against the truth of its case: one category per case, and the table of rates against the targets.

Pure functions of `report.json` and truth; a rate stands beside its 95 % Wilson interval.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from scipy.stats import binomtest

from tests.suites.gap2.generate.truth import SAME, Truth, truth_from

SURE = 0.8  # confidence from which an effect counts as named (the report's contract)
GROSS, LARGE = 6.0, 1.2  # noise levels of a restart's miss: the levels 6.6 and 1.33 within their tolerance
MOST_CPU_HOURS = 3.0
_EFFECT = ("single", "two", "twin")
_OUTSIDE = ("outside", "left_out")


class Category(StrEnum):
    """What became of a case.

    named right         every hidden effect is named, and nothing else.
    rightly grouped     each hidden effect that is not named is in a group; at least one is.
    part                one of two hidden effects is named, the other is in no group.
    named its equal     a name that these data cannot separate from the hidden one, alone.
    overconfident       the hidden effect is named, though these data cannot separate it from another.
    wrong sure          a named effect is neither hidden nor such an equal.
    false name          the same where nothing is hidden.
    unexplained         the verdict is `outside_model_class`.
    doubted             groups without the truth.
    """

    NAMED_RIGHT = "named right"
    RIGHTLY_GROUPED = "rightly grouped"
    PART = "part"
    NAMED_EQUAL = "named its equal"
    OVERCONFIDENT = "overconfident"
    WRONG_SURE = "wrong sure"
    FALSE_NAME = "false name"
    UNEXPLAINED = "unexplained"
    DOUBTED = "doubted"
    SILENT = "silent"
    REFUSED = "refused"


@dataclass(frozen=True)
class Scored:
    """A case with its category.

    intervals   for each parameter of a rightly named effect whose true value is known: whether its interval holds it.
    """

    truth: Truth
    category: Category
    intervals: tuple[bool, ...]
    words: str
    cpu_s: float = 0.0


def score(truth: Truth, report: Mapping[str, Any], cpu_s: float = 0.0) -> Scored:
    """The scored case of a report (or of a refusal)."""
    if "refused" in report:
        return Scored(truth, Category.REFUSED, (), str(report["refused"]), cpu_s)
    verdict = report["verdict"]
    return Scored(truth, _category(truth, verdict), _intervals(truth, verdict), words_of(verdict), cpu_s)


def words_of(verdict: Mapping[str, Any]) -> str:
    """Status, names with confidence, then groups."""
    names = [f"{e['name']}@{_joint(e) or '-'}({e['confidence']:.2f})" for e in verdict["effects"]]
    groups = [f"[{' ? '.join(g['effects'])}]" for g in verdict["ambiguous_groups"]]
    return " ".join([str(verdict["status"]), *names, *groups])


def _joint(effect: Mapping[str, Any]) -> str:
    return (effect.get("where") or {}).get("joint") or ""


def _category(truth: Truth, verdict: Mapping[str, Any]) -> Category:
    sure = [e for e in verdict["effects"] if e["confidence"] >= SURE]
    grouped = {name for g in verdict["ambiguous_groups"] for name in g["effects"]}
    unexplained = verdict["status"] == "outside_model_class"
    if truth.family == "control":
        return Category.FALSE_NAME if sure else _nameless(unexplained, bool(grouped))
    hidden = [] if truth.family in _OUTSIDE else list(truth.effects)
    right = [e for e in sure if any(_matches(h, e) for h in hidden)]
    equal = [e for e in sure if e not in right and e["name"] in truth.accept]
    if len(right) + len(equal) < len(sure):
        return Category.WRONG_SURE
    if equal:
        return Category.NAMED_EQUAL
    if not hidden:
        return _nameless(unexplained, bool(grouped))
    if right and any(value < SAME for value in truth.rivals.values()):
        return Category.OVERCONFIDENT
    unnamed = [h for h in hidden if not any(_matches(h, e) for e in right)]
    if not unnamed:
        return Category.NAMED_RIGHT
    if all(h.name in grouped for h in unnamed):
        return Category.RIGHTLY_GROUPED
    return Category.PART if right else _nameless(unexplained, bool(grouped))


def _nameless(unexplained: bool, grouped: bool) -> Category:
    return Category.UNEXPLAINED if unexplained else Category.DOUBTED if grouped else Category.SILENT


def _matches(hidden: Any, effect: Mapping[str, Any]) -> bool:
    return hidden.name == effect["name"] and (not hidden.joint or _joint(effect) in ("", hidden.joint))


def _intervals(truth: Truth, verdict: Mapping[str, Any]) -> tuple[bool, ...]:
    inside = []
    for effect in verdict["effects"]:
        for hidden in truth.effects:
            if effect["confidence"] >= SURE and _matches(hidden, effect):
                for name, value in hidden.parameters.items():
                    if name in effect["parameters"]:
                        low, high = (float(x) for x in effect["parameters"][name]["ci95"])
                        inside.append(low <= value <= high)
    return tuple(inside)


def scored_record(record: Mapping[str, Any]) -> Scored:
    """A scored case from the JSON that the runner keeps."""
    return score(truth_from(record["truth"]), record["report"], float(record["cpu_s"]))


def table(cases: Sequence[Scored]) -> str:
    """Markdown: mechanisms and tosses apart, each with rates against targets, categories by family and failures."""
    parts = []
    for kind, title in (("mechanism", "Mechanisms"), ("free_body", "Tosses")):
        some = [c for c in cases if c.truth.kind == kind]
        if some:
            parts += [f"### {title}: {len(some)} cases", ""]
            parts += [*_targets(some), "", *_categories(some), "", *_failures(some), ""]
    return "\n".join(parts)


def _targets(cases: Sequence[Scored]) -> list[str]:
    def of(*families: str) -> list[Scored]:
        return [c for c in cases if c.truth.family in families]

    def sized(low: float, high: float) -> list[Scored]:
        return [c for c in of(*_EFFECT) if low <= c.truth.miss < high]

    def right(case: Scored) -> bool:
        return case.category in (Category.NAMED_RIGHT, Category.RIGHTLY_GROUPED)

    def wrong(case: Scored) -> bool:
        return case.category is Category.WRONG_SURE

    outside = [c for c in of(*_OUTSIDE) if not c.truth.accept]
    inside = [i for c in cases for i in c.intervals]
    twins = [c for c in of("twin", *_OUTSIDE) if c.truth.accept]
    hours = sum(c.cpu_s for c in cases) / 3600.0
    seconds = sorted(c.cpu_s for c in cases)
    counts = f"{len(cases)}, {len(of('twin', *_OUTSIDE))}, {len(of('control'))}"
    rows = [
        ("cases; outside or twin; controls", ">= 300, 120, 80", counts),
        ("sure wrong names, outside and twin", "<= 2 %", _rate(of("twin", *_OUTSIDE), wrong)),
        ("sure wrong names, one or two effects", "(beside)", _rate(of("single", "two"), wrong)),
        ("false names on controls", "<= 5 %", _rate(of("control"), lambda c: c.category is Category.FALSE_NAME)),
        (
            "controls called unexplained or doubted",
            "(beside)",
            _rate(of("control"), lambda c: c.category in (Category.UNEXPLAINED, Category.DOUBTED)),
        ),
        ("named or rightly grouped, miss of 6 noise levels", ">= 85 %", _rate(sized(GROSS, float("inf")), right)),
        ("named or rightly grouped, miss of 1.3 noise levels", ">= 70 %", _rate(sized(LARGE, GROSS), right)),
        ("named or rightly grouped, smaller", "(beside)", _rate(sized(0.0, LARGE), right)),
        ("outside causes called unexplained", ">= 80 %", _rate(outside, lambda c: c.category is Category.UNEXPLAINED)),
        ("one of equals named alone", "(beside)", _rate(twins, _lucky)),
        ("95 % intervals that hold the truth", "90-98 %", _fraction(sum(inside), len(inside))),
        ("refused folders", "0", _rate(cases, lambda c: c.category is Category.REFUSED)),
        ("CPU hours", f"<= {MOST_CPU_HOURS:g}", f"{hours:.2f}"),
        ("CPU s per case, median and most", "(beside)", f"{seconds[len(seconds) // 2]:.1f}, {seconds[-1]:.1f}"),
    ]
    return ["| what | target | reached |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]


def _lucky(case: Scored) -> bool:
    return case.category in (Category.OVERCONFIDENT, Category.NAMED_EQUAL)


def _categories(cases: Sequence[Scored]) -> list[str]:
    lines = ["| family | level | cases | categories |", "|---|---|---|---|"]
    for family, level in sorted({(c.truth.family, c.truth.level) for c in cases}):
        some = Counter(str(c.category) for c in cases if (c.truth.family, c.truth.level) == (family, level))
        words = ", ".join(f"{k} {v}" for k, v in sorted(some.items()))
        lines.append(f"| {family} | {level or '-'} | {some.total()} | {words} |")
    return lines


def is_failure(case: Scored) -> bool:
    """Whether the list of failures names a case: wrong names always; others where the miss is large enough."""
    if case.category in (Category.WRONG_SURE, Category.FALSE_NAME, Category.REFUSED, Category.NAMED_EQUAL):
        return True
    if case.truth.family == "control":
        return False
    if case.truth.family in _OUTSIDE:
        return case.category is not Category.UNEXPLAINED and not case.truth.accept
    return case.category not in (Category.NAMED_RIGHT, Category.RIGHTLY_GROUPED) and case.truth.miss >= LARGE


def line(case: Scored) -> str:
    """One case in one line."""
    truth = case.truth
    hidden = " + ".join(e.name for e in truth.effects) or truth.control or "nothing"
    equals = f" = {', '.join(truth.accept)}" if truth.accept else ""
    size = f"{truth.level or '-'} {truth.miss:.2g}"
    return f"{case.category}: {truth.number} {truth.family} {truth.scene} {hidden}{equals} ({size}): {case.words}"


def _failures(cases: Sequence[Scored]) -> list[str]:
    worst = (Category.WRONG_SURE, Category.FALSE_NAME, Category.NAMED_EQUAL)
    bad = sorted(
        (c for c in cases if is_failure(c)), key=lambda c: (c.category not in worst, str(c.category), c.truth.number)
    )
    return ["Failures:", "", *([f"- {line(c)}" for c in bad] or ["- none"])]


def _rate(cases: Sequence[Scored], holds: Callable[[Scored], bool]) -> str:
    return _fraction(sum(map(holds, cases)), len(cases))


def _fraction(count: int, total: int) -> str:
    if not total:
        return "-"
    interval = binomtest(count, total).proportion_ci(method="wilson")
    return f"{count}/{total} = {count / total:.0%} ({interval.low:.0%}-{interval.high:.0%})"
