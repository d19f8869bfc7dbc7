"""The suite's table: shares with 95 % intervals (Wilson), and every failure by what happened."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.stats import binomtest

Record = Mapping[str, object]
_FALSE = ("invented", "wrong")
_LEVEL = 0.05  # a perfect model whose gain is no surer than this over trials leaves nothing to be named


def table(records: Sequence[Record]) -> str:
    """Markdown: targets against what was reached, outcomes per family and size, failures."""
    return "\n".join([*_targets(records), "", *_outcomes(records), "", *_failures(records)])


def _targets(records: Sequence[Record]) -> list[str]:
    def of(*families: str, size: str | None = None) -> list[Record]:
        return [r for r in records if r["family"] in families and size in (None, r["size"])]

    def seen(*families: str, size: str | None = None) -> list[Record]:
        return [r for r in of(*families, size=size) if _seen(r)]

    sized = of("single", "two", "pair")
    # Beside a perfect model that gains nothing there is no share of it.
    told = [r for r in sized if r["outcome"] in ("named", "pair") and _number(r["ideal"]) > 0.0]
    gains = [_number(r["reduction"]) / _number(r["ideal"]) for r in told]
    covered = [bool(c) for r in sized for c in _list(r["covered"])]
    spent = sorted(_number(r["cpu_s"]) for r in records)
    rows = [
        ("false names on controls", "<= 5 %", _share(of("control"), lambda r: r["outcome"] == "invented")),
        ("sure names for outside effects", "0", _share(of("outside"), lambda r: r["outcome"] == "invented")),
        ("wrong sure names, effect present", "few", _share(sized, lambda r: r["outcome"] == "wrong")),
        ("named, large", ">= 85 %", _share(seen("single", size="large"), lambda r: r["outcome"] == "named")),
        ("named, middle", ">= 70 %", _share(seen("single", size="middle"), lambda r: r["outcome"] == "named")),
        (
            "named, large and middle, a perfect model's gain is chance over trials",
            "abstaining is right",
            _share(
                [r for r in of("single") if r["size"] != "small" and not _seen(r)], lambda r: r["outcome"] == "named"
            ),
        ),
        ("named, small", "abstaining is right", _share(of("single", size="small"), lambda r: r["outcome"] == "named")),
        ("first name is right, sure or not, large", "(beside)", _share(seen("single", size="large"), _first_right)),
        ("first name is right, sure or not, middle", "(beside)", _share(seen("single", size="middle"), _first_right)),
        ("both of two named", "", _share(of("two"), lambda r: r["outcome"] == "named")),
        (
            "doubles reported as such, large and middle",
            ">= 80 %",
            _share([r for r in seen("pair") if r["size"] != "small"], lambda r: r["outcome"] in ("pair", "wide")),
        ),
        ("95 % intervals that hold the truth", "90-98 %", _fraction(sum(covered), len(covered))),
        ("held-out gain of named over a perfect model's, median", ">= 80 %", _median(gains)),
        ("area under risk over coverage, of cases with a name", "small", _risk_over_coverage(records)),
        ("held-out gain on controls, least", ">= 0", _least([_number(r["reduction"]) for r in of("control")])),
        ("CPU s per case, median and most", "<= 15", f"{np.median(spent):.1f}, {spent[-1]:.1f}" if spent else "-"),
        ("best by BIC alone is the truth", "(beside us)", _share(of("single"), _bic_right)),
        ("a name at random is the truth", "(beside us)", _at_random(of("single"))),
    ]
    return ["| what | target | reached |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]


def _outcomes(records: Sequence[Record]) -> list[str]:
    lines = ["| family | size | cases | outcomes |", "|---|---|---|---|"]
    for family, size in dict.fromkeys((str(r["family"]), str(r["size"])) for r in records):
        some = Counter(str(r["outcome"]) for r in records if (r["family"], r["size"]) == (family, size))
        words = ", ".join(f"{k} {v}" for k, v in sorted(some.items()))
        lines.append(f"| {family} | {size} | {some.total()} | {words} |")
    return lines


def _failures(records: Sequence[Record]) -> list[str]:
    """Wrong names first; to miss what is small or met in too few trials is no failure."""
    fine = ("silent", "named", "pair", "wide")
    bad = [
        r
        for r in records
        if r["outcome"] not in fine and not ((r["size"] == "small" or not _seen(r)) and r["outcome"] not in _FALSE)
    ]
    bad.sort(key=lambda r: (r["outcome"] not in _FALSE, str(r["outcome"]), str(r["name"])))
    lines = [f"- {r['outcome']}: {r['name']}; said {r['said'] or 'nothing'}" for r in bad]
    return ["Failures:", "", *(lines or ["- none"])]


def _seen(record: Record) -> bool:
    return _number(record.get("chance", 0.0)) < _LEVEL


def _bic_right(record: Record) -> bool:
    return record["best_by_bic"] in {str(t).partition("@")[0] for t in _list(record["truth"])}


def _first_right(record: Record) -> bool:
    name, _, place = str(record["first"]).partition("@")
    return bool(name) and bool({name, f"{name}@{place}"} & {str(t) for t in _list(record["truth"])})


def _risk_over_coverage(records: Sequence[Record]) -> str:
    """Mean share of wrong first names among the k surest, over all k (Geifman and El-Yaniv, NeurIPS 2017)."""
    named = sorted((r for r in records if r["first"]), key=lambda r: -_number(r["confidence"]))
    wrong = np.array([not _first_right(r) for r in named], dtype=float)
    return f"{np.mean(np.cumsum(wrong) / np.arange(1, len(wrong) + 1)):.3f} of {len(named)}" if named else "-"


def _at_random(records: Sequence[Record]) -> str:
    chances = [1.0 / _number(r["candidates"]) for r in records if _number(r["candidates"])]
    return f"{np.mean(chances):.0%} of {len(chances)}" if chances else "-"


def _least(values: Sequence[float]) -> str:
    return f"{min(values):.3f}" if values else "-"


def _share(records: Sequence[Record], holds: Callable[[Record], bool]) -> str:
    return _fraction(sum(map(holds, records)), len(records))


def _fraction(count: int, total: int) -> str:
    if not total:
        return "-"
    interval = binomtest(count, total).proportion_ci(method="wilson")
    return f"{count}/{total} = {count / total:.0%} ({interval.low:.0%}-{interval.high:.0%})"


def _median(values: Sequence[float]) -> str:
    return f"{np.median(values):.0%} of {len(values)}" if values else "-"


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def _list(value: object) -> list[object]:
    return list(value) if isinstance(value, list | tuple) else []
