"""The incremental parser gives the same tree as the parser of whole texts, for any edit."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from schemas.diagnostics import Diagnostic, InvalidInput
from source.incremental_parse import IncrementalParser
from source.parse import Parsed, parse

ROOT = Path(__file__).parents[2]
FILES = [*(ROOT / "tests" / "data" / "scenes").glob("*.yaml"), *(ROOT / "examples" / "scenes").glob("*.yaml")]
TEXTS = [file.read_text() for file in sorted(FILES)]
BITS = [
    *"{}[]:-#'\"|>&*,?!% \n\t",
    "\n- ",
    "\n  ",
    ": ",
    "a: 1\n",
    "- 1\n",
    "...\n",
    "---\n",
    "|\n",
    ">+\n",
    "\r\n",
    "\u2028",
]


def outcome(read, text: str) -> Parsed | Diagnostic:
    try:
        return read(text.encode(), "p.yaml")
    except InvalidInput as error:
        return error.diagnostic


@st.composite
def edited(draw: st.DrawFn) -> tuple[str, str]:
    """A text and the same with up to three places changed."""
    text = after = draw(st.sampled_from(TEXTS))
    for _ in range(draw(st.integers(0, 3))):
        at = draw(st.integers(0, len(after)))
        gone = draw(st.sampled_from([0, 0, 1, 2, 20, 200]))
        after = after[:at] + draw(st.sampled_from(["", *BITS])) + after[at + gone :]
    return text, after


@settings(max_examples=300, deadline=None)
@given(edited())
def test_an_edited_text_read_in_pieces_is_the_text_read_as_a_whole(texts: tuple[str, str]):
    before, after = texts
    parser = IncrementalParser()
    outcome(parser.parse, before)
    assert outcome(parser.parse, after) == outcome(parse, after)


@pytest.mark.parametrize(
    "text",
    [
        "a: {b: 1}\n{c: 2}\n",
        "a:\n  {b: 1}\n  {c: 2}\n",
        "a: |\n  x",
        "a: |+\n  x\n\n\nb: 1\n",
        "a: 'one\nb: two'\n",
        "a: [1,\nb: 2]\n",
        "a: 1\na: 2\n",
        "? a\n: b\nc: 1\n",
        "a: &x 1\nb: *x\n",
        "a:\n- 1\n- 2\nb: # what\n  - {c: 1}\n  # more\n  - 3\n",
        "a: 1\n...\nb: 2\n",
        "%YAML 1.1\n---\na: yes\n",
        "- a\n- b: 1\n  c: 2\n",
        " a: 1\n b: 2\nc: 3\n",
        "a:\n  one\n  two\nb: 1\n",
        "a: \ufeff1\n",
        "a:\n  b:\n  c: 1\n",
        "a:\n  -\n  - 1\nb:\n",
        "",
        "# nothing\n",
    ],
)
def test_corners_of_yaml_are_read_alike(text: str):
    parser = IncrementalParser()
    assert outcome(parser.parse, text) == outcome(parse, text)
    assert outcome(parser.parse, "# moved\n" + text) == outcome(parse, "# moved\n" + text)


def test_only_what_changed_is_parsed_again(monkeypatch: pytest.MonkeyPatch):
    text = "objects:\n" + "".join(f"  - {{id: o{i}}}\n" for i in range(9)) + "clearance: 0.01\n"
    parser, seen = IncrementalParser(), list[bytes]()
    parser.parse(text.encode(), "p.yaml")
    monkeypatch.setattr("source.incremental_parse.parse", lambda data, *rest: seen.append(data) or parse(data, *rest))
    parser.parse(("# a line more\n" + text.replace("o4", "other")).encode(), "p.yaml")
    assert seen == [b"  - {id: other}\n"]


@st.composite
def renumbered(draw: st.DrawFn) -> tuple[str, str]:
    """A text with decimals and the same with other digits in some of them, in quotes, keys and comments as well."""
    lines = [
        "a: {b: 0.25, c: [1.5, -0.75]}",
        "d: '0.50'",
        "e: 0.5 m",
        "0.25: 1",
        "f: 2.50 # 3.5",
        "g: 1.2.3",
        "h: 00.5",
    ]
    before = "\n".join(draw(st.lists(st.sampled_from(lines), min_size=1, max_size=7, unique=True))) + "\n"
    places = [k for k, letter in enumerate(before) if letter.isdigit()]
    after = list(before)
    for k in draw(st.lists(st.sampled_from(places), max_size=4)):
        after[k] = draw(st.sampled_from("0123456789"))
    return before, "".join(after)


@settings(max_examples=100, deadline=None)
@given(renumbered())
def test_a_text_with_other_numbers_is_read_as_a_whole_text_is(texts: tuple[str, str]):
    before, after = texts
    parser = IncrementalParser()
    outcome(parser.parse, before)
    assert outcome(parser.parse, after) == outcome(parse, after)


def test_other_numbers_of_the_same_length_need_no_parser(monkeypatch: pytest.MonkeyPatch):
    text = "objects:\n  - {id: cup, size_m: [0.10, 0.25, 1.5]} # 0.1 m\n  - {id: pot, size_m: [0.10, 0.25, 1.5]}\n"
    parser, after = IncrementalParser(), "# moved\n" + text.replace("0.25", "0.40")
    parser.parse(text.encode(), "p.yaml")
    whole = parse(after.encode(), "p.yaml")
    monkeypatch.setattr("source.incremental_parse.parse", None)
    assert parser.parse(after.encode(), "p.yaml") == whole
