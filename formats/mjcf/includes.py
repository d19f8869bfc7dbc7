"""Puts what included MJCF files hold in the place of their `<include>` elements.

mujoco.readthedocs.io/en/stable/XMLreference.html#include: names are relative to the folder of the main file (else, as
MuJoCo 3 does, of the including one), and no file is included twice, which also rules out cycles.
"""

from __future__ import annotations

from pathlib import Path

from formats.xml_elements import Element, parse_file, refuse


def with_includes(top: Element, folder: Path, root: Path) -> Element:
    """`top` with all includes replaced, those in included files too. Nothing outside `root` is opened.

    Raises InvalidInput (`robot/path-escape`, `robot/missing-file`, `robot/repeated-include`, `robot/unreadable`,
    `robot/xml-declarations`, `robot/missing-name`).
    """
    included: set[Path] = {(root / top.source.file).resolve()}
    waiting: list[tuple[Element, Path]] = [(top, folder)]
    while waiting:
        element, at = waiting.pop()
        children: list[Element] = []
        for child in element.children:
            if child.tag != "include":
                children.append(child)
                waiting.append((child, at))
                continue
            path = _included(child, folder, at, root)
            if path in included:
                headline = f"'{child.get('file')}' is included a second time"
                refuse("robot/repeated-include", headline, child.source, value=child.get("file"))
            included.add(path)
            content = parse_file(path, root)
            children.append(Element("include", dict(child.attributes), child.source, children=content.children))
            waiting.append((children[-1], path.parent))
        element.children = children
    _splice(top)
    return top


def _included(include: Element, main: Path, folder: Path, root: Path) -> Path:
    """The real path of the included file."""
    name, top = include.get("file"), root.resolve()
    if not name:
        refuse("robot/missing-name", "an <include> names no file", include.source)
    inside = [path for path in ((at / name).resolve() for at in (main, folder)) if path.is_relative_to(top)]
    if not inside:
        headline = f"the included file '{name}' lies outside the folder of the model"
        refuse("robot/path-escape", headline, include.source, value=name)
    path = next((path for path in inside if path.is_file()), None)
    if path is None:
        refuse("robot/missing-file", f"the included file '{name}' is absent", include.source, value=name)
    return path


def _splice(top: Element) -> None:
    """Replaces the remaining `<include>` elements, which hold what their files hold, by their children."""
    for element in top.walk():
        while any(child.tag == "include" for child in element.children):
            element.children = [
                inner for child in element.children for inner in (child.children if child.tag == "include" else [child])
            ]
