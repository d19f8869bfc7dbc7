"""XML as elements: lines, source text, refusal of declarations; and what is written reads back."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formats.xml_elements import Element, parse_bytes, parse_file
from formats.xml_text import element, to_bytes
from schemas.diagnostics import InvalidInput

NESTED = b"""<?xml version="1.0"?>
<a>
  <b x="1>2"
     y="3"/>
  <!-- between --><c>text<c/></c >
  <d></d>
</a>"""


def refusal(data: bytes) -> tuple[str, int | None]:
    with pytest.raises(InvalidInput) as refused:
        parse_bytes(data, "model.urdf")
    diagnostic = refused.value.diagnostic
    assert diagnostic.where.file == "model.urdf"
    return diagnostic.code, diagnostic.where.line


def test_elements_know_their_lines_and_their_text() -> None:
    top = parse_bytes(NESTED, "f")
    assert [(e.tag, e.source.line) for e in top.walk()] == [("a", 2), ("b", 3), ("c", 5), ("c", 5), ("d", 6)]
    assert [e.text for e in top.children] == ['<b x="1>2"\n     y="3"/>', "<c>text<c/></c >", "<d></d>"]
    assert top.children[1].children[0].text == "<c/>"
    assert top.text == NESTED.decode().partition("\n")[2]


@pytest.mark.parametrize(
    "declaration",
    [
        '<!DOCTYPE r [<!ENTITY e "x">]>',
        '<!DOCTYPE r SYSTEM "file:///etc/hostname">',
        '<!DOCTYPE r PUBLIC "p" "http://example.org/r.dtd">',
        '<!DOCTYPE r [<!ENTITY % p SYSTEM "file:///etc/hostname"> %p;]>',
        "<!DOCTYPE r [<!ATTLIST r a CDATA 'x'>]>",
    ],
)
def test_declarations_are_refused(declaration: str) -> None:
    assert refusal(f"\n{declaration}\n<r/>".encode())[0] == "robot/xml-declarations"


def test_a_document_type_without_declarations_is_harmless() -> None:
    assert parse_bytes(b"<!DOCTYPE robot><robot a='&lt;&#65;'/>", "f").get("a") == "<A"


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (b"", 1),
        (b"<a>\n<b>\n</a>", 3),
        (b"<a/>\n<b/>", 2),
        (b"<a>&e;</a>", 1),
        (b"<a x='1' x='2'/>", 1),
        (b"\xff\xfe", 1),
    ],
)
def test_what_is_no_xml_is_refused_with_its_line(data: bytes, line: int) -> None:
    assert refusal(data) == ("robot/unreadable", line)


def test_an_unknown_encoding_is_refused() -> None:
    assert refusal(b'<?xml version="1.0" encoding="klingon"?><a/>')[0] == "robot/unreadable"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings_of_xml_are_read(encoding: str) -> None:
    name = encoding.removesuffix("-sig")
    data = f'<?xml version="1.0" encoding="{name}"?><a x="é"/>'.encode(encoding)
    assert parse_bytes(data, "f").get("x") == "é"


def test_a_file_that_is_absent_or_a_folder_is_named(tmp_path: Path) -> None:
    for name in ("none.urdf", "."):
        with pytest.raises(InvalidInput) as refused:
            parse_file(tmp_path / name, tmp_path)
        assert refused.value.diagnostic.code == "robot/missing-file"


def test_a_file_outside_the_root_is_not_opened(tmp_path: Path) -> None:
    (tmp_path / "root").mkdir()
    (tmp_path / "out.xml").write_text("<robot/>")
    (tmp_path / "root" / "link.xml").symlink_to(tmp_path / "out.xml")
    for path in (tmp_path / "out.xml", tmp_path / "root" / "link.xml"):
        with pytest.raises(InvalidInput) as refused:
            parse_file(path, tmp_path / "root")
        assert refused.value.diagnostic.code == "robot/path-escape"


attributes = st.dictionaries(
    st.sampled_from("abcde"), st.text(st.characters(exclude_categories=("Cs", "Cc"))), max_size=3
)
trees = st.recursive(
    attributes.map(lambda a: element("x", **a)),
    lambda inner: st.builds(lambda a, children: element("y", *children, **a), attributes, st.lists(inner, max_size=3)),
)


def plain(top: Element) -> tuple[str, dict[str, str], list[object]]:
    return top.tag, top.attributes, [plain(child) for child in top.children]


@given(trees)
def test_what_is_written_is_read(top: Element) -> None:
    assert plain(parse_bytes(to_bytes(top), "f")) == plain(top)


def test_deep_elements_take_linear_time() -> None:
    depth = 50_000
    began_s = time.process_time()
    top = parse_bytes(b"<a>" * depth + b"</a>" * depth, "f")
    assert sum(1 for _ in top.walk()) == depth
    assert time.process_time() - began_s < 5.0
