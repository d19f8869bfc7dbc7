"""The documents hold together: links, reachability, and no results on explanation pages.

Input: README.md, CONTRIBUTING.md and the Markdown files below docs/. Each law is a function from text to complaints, so
that the tests can also show that it finds what it is for.
"""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.codes import CODES

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
LINKING = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *PAGES]
EXPLANATION = sorted((DOCS / "explanation").glob("*.md"))
PACKAGES = sorted(p.parent for p in ROOT.glob("*/__init__.py"))
CODE = [path for package in PACKAGES for path in sorted(package.rglob("*.py"))]

MOST_LINES = 80  # of an explanation page: what a reader takes in at one sitting (Rules from now on, 10).
MOST_COLUMNS = 120  # of its prose, as of the code; otherwise 80 lines could hold any amount of text.

LINK = re.compile(r"\[[^\]]*\]\(([^()\s]+)\)")
FENCE = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
# A result is a figure that another commit, machine or data set changes. What gives it away, with a sample of each:
RESULTS = {
    "commit": (r"\b(?=[0-9a-f]*[0-9])(?=[0-9a-f]*[a-f])[0-9a-f]{7,40}\b", "measured at 6d4f72d"),
    "date": (
        r"\b\d{4}-\d{2}-\d{2}\b|\b(?:January|February|March|April|May|June|July|August|September|October|November"
        r"|December) \d{4}\b",
        "in the evening of 22 November 2026",
    ),
    "command of a measurement": (r"python -m (?:benchmarks|tests|examples)\.", "`python -m benchmarks.assets.mass A`"),
    "count of successes": (r"(?<![\d.])\d[\d,]* (?:of|in|out of) (?:the )?\d[\d,]*\b", "58 of 62 anchors"),
    "percentage with its count or interval": (r"\d ?% ?[\[(]-?[\d.]+(?:, ?| to )-?\d", "64 % [50, 78] less error"),
    "value with its error": (r"\d\s*(?:\+-|±)\s*\d", "friction is 0.207 +- 0.005"),
    "state of a machine": (r"\b(?:busy|loaded|calm) machine\b|\bbeside other work\b", "CPU seconds on a busy machine"),
    "cost in time": (r"\d (?:CPU|processor) ?(?:ms|s|seconds?|minutes?)\b|\bCPU: |\bmedian \d", "CPU: median 0.03 s"),
    "numbered case": (r"\b[Cc]ases? \d{3,}", "in case 1050 it drifts"),
    "row of figures": (r"^\|(?:[^|\n]*\|)*?(?:\s*[-\d.,x% ]*\d[-\d.,x% ]*\|){3}", "| 10 | 8.4 | 40 | 0.4 |"),
}
NO_RESULTS = (
    "The limit is 64 hulls of 64 points, 1.5 times the width, at 240 Hz.",
    "Kept is what is 4 % of the footprint (a disc of 12 % of the breadth fits).",
    "The position is drawn evenly, four times of five where a camera sees it.",
    "| lid, cap | jar, bottle | a separate piece within 25° | 0.8 |",
    "It was accepted and defaced.",
    "A class is accepted with 50 % (65 % when only appearance supports it).",
)


def links_of(text: str) -> list[str]:
    """Targets of the links and pictures in `text`, without those in fenced code."""
    return LINK.findall(FENCE.sub("", text))


def anchors_of(text: str) -> set[str]:
    """The anchors that GitHub gives the headings of `text`."""
    seen: Counter[str] = Counter()
    anchors = set[str]()
    for heading in re.findall(r"^#+ +(.+?) *$", FENCE.sub("", text), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        anchors.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
        seen[slug] += 1
    return anchors


def broken(page: Path, text: str) -> list[str]:
    """Relative links of a page that lead to no file inside the repository, or to no heading of it."""
    wrong: list[str] = []
    for link in links_of(text):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        headings = anchors_of(target.read_text() if path else text) if anchor and target.is_file() else {anchor}
        if not target.exists() or not target.is_relative_to(ROOT) or anchor not in headings:
            wrong.append(link)
    return wrong


def too_long(text: str) -> list[str]:
    """Why a page is longer than one sitting: its number of lines, or lines of prose beyond the limit."""
    lines = text.splitlines()
    prose = [line for line in lines if not line.lstrip().startswith(("|", "!["))]
    wide = [line for line in prose if len(line) > MOST_COLUMNS]
    return ([f"{len(lines)} lines"] if len(lines) > MOST_LINES else []) + wide


def results_in(text: str) -> list[str]:
    """What gives away results, each with its kind."""
    return [
        f"{kind}: {match.group()}"
        for kind, (pattern, _) in RESULTS.items()
        for match in re.finditer(pattern, text, re.MULTILINE)
    ]


def reached(start: Path) -> set[Path]:
    """All Markdown files to which links lead from `start`, itself included."""
    known, waiting = {start}, [start]
    while waiting:
        page = waiting.pop()
        for link in links_of(page.read_text()):
            target = (page.parent / link.partition("#")[0]).resolve()
            if target.suffix == ".md" and target.is_file() and target not in known:
                known.add(target)
                waiting.append(target)
    return known


def missing_code(text: str) -> list[str]:
    """Files, modules and members of our packages that `text` names in backticks and that do not exist."""
    names = {package.name for package in PACKAGES}
    named = re.findall(r"`([a-z_]\w*(?:[./]\w+)+)(?=[`/(\s:])", FENCE.sub("", text))
    return [n for n in named if re.split(r"[./]", n)[0] in names and n not in CODES and not exists(n)]


def exists(name: str) -> bool:
    """Whether `a/b.py`, `a.b` or `a.b.member` exists below the repository; file names of other kinds count as such."""
    if "/" in name:
        return (ROOT / name).exists()
    parts = name.split(".")
    if len(parts) == 2 and parts[1] in {"usda", "json", "html", "yaml"}:
        return True
    for taken in range(len(parts), 0, -1):
        at = ROOT.joinpath(*parts[:taken])
        module = at.with_suffix(".py") if at.with_suffix(".py").is_file() else at / "__init__.py"
        if module.is_file():
            return all(re.search(rf"\b{re.escape(p)}\b", module.read_text()) for p in parts[taken:])
    return False


def ids(pages: list[Path]) -> Iterator[str]:
    return (str(page.relative_to(ROOT)) for page in pages)


@pytest.mark.parametrize("page", LINKING, ids=ids(LINKING))
def test_every_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    assert not broken(page, page.read_text())


def test_broken_links_are_found() -> None:
    page = DOCS / "index.md"
    good = "[a](glossary.md) [b](#here) ![c](images/demo.png) [d](https://example.org/x)\n\n## Here\n\n## Here\n"
    assert broken(page, good + "[e](#here-1)") == []
    bad = "[a](nowhere.md) [b](#there) [c](glossary.md#no-such-word) [d](../../elsewhere.md)\n"
    assert broken(page, bad) == ["nowhere.md", "#there", "glossary.md#no-such-word", "../../elsewhere.md"]
    assert broken(page, "[split\nover lines](nowhere.md)") == ["nowhere.md"]
    assert broken(page, "```\n[code](nowhere.md)\n```\n") == []


@pytest.mark.parametrize("page", EXPLANATION, ids=ids(EXPLANATION))
def test_explanation_fits_one_sitting(page: Path) -> None:
    assert not too_long(page.read_text())


def test_long_pages_are_found() -> None:
    assert too_long("word\n" * MOST_LINES) == []
    assert too_long("word\n" * (MOST_LINES + 1)) == [f"{MOST_LINES + 1} lines"]
    assert too_long("x" * (MOST_COLUMNS + 1)) != []


@pytest.mark.parametrize("page", EXPLANATION, ids=ids(EXPLANATION))
def test_explanation_holds_no_results(page: Path) -> None:
    assert not results_in(page.read_text()), "results belong into docs/benchmarks*.md, with command and commit"


@pytest.mark.parametrize("kind", RESULTS)
def test_results_of_each_kind_are_found(kind: str) -> None:
    assert any(found.startswith(f"{kind}: ") for found in results_in(RESULTS[kind][1]))


@pytest.mark.parametrize("sentence", NO_RESULTS)
def test_limits_and_plain_words_are_no_results(sentence: str) -> None:
    assert results_in(sentence) == []


def test_every_page_is_reachable_from_the_index() -> None:
    assert sorted(set(PAGES) - reached(DOCS / "index.md")) == []
    assert DOCS / "index.md" in reached(ROOT / "README.md")


@pytest.mark.parametrize("page", LINKING, ids=ids(LINKING))
def test_code_that_a_page_names_exists(page: Path) -> None:
    assert not missing_code(page.read_text())


def test_code_that_does_not_exist_is_found() -> None:
    assert missing_code("`schemas/codes/use.py` `schemas.codes.use` `schemas.codes.CODES` `schemas.codes`") == []
    lost = ["schemas/no_such.py", "schemas.no_such", "schemas.codes.use.NO_SUCH"]
    assert missing_code(" ".join(f"`{name}`" for name in lost)) == lost


def test_pages_that_code_names_exist() -> None:
    named = {(path, page) for path in CODE for page in re.findall(r"docs/[\w/-]+\.md", path.read_text())}
    assert named
    assert not {(path, page) for path, page in named if not (ROOT / page).exists()}
