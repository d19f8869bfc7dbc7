"""Files of a program put together: `include` at any node, and sections that stand under `definition`.

`include: file.yaml` in a mapping expands that file there, then lays the other keys of the mapping over it; of a list of
files each lies over those before it. Paths are relative to the including file and stay inside the root folder.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as FilePath

from scenec.source.merge import merge, settled
from scenec.source.parse import MAX_VALUES, Parsed, parse, too_large
from scenec.source.tree import Block, Item, Row, Scalar, Tree
from schemas.diagnostics import Diagnostic, InvalidInput, Label, Location, finding
from schemas.scene.program import SceneProgram

MAX_FILES = 1000  # each time that one is included counts
INCLUDE, DEFINITION = "include", "definition"
Parse = Callable[[bytes, str], Parsed]
SECTIONS = frozenset(SceneProgram.model_fields) - {DEFINITION}


def load(file: FilePath, root: FilePath, parse: Parse = parse) -> tuple[Tree | None, tuple[Diagnostic, ...]]:
    """The whole program that begins in `file`, None when nothing of it can be read; all findings of one run.

    Findings name files relative to `root`, which must be resolved.
    """
    loader = _Loader(root, parse)
    try:
        tree: Tree | None = loader.program(file, Location(file=file.name), ())
    except InvalidInput as error:
        loader.found.append(error.diagnostic)
        tree = None
    return tree, tuple(loader.found)


class _Loader:
    def __init__(self, root: FilePath, parse: Parse) -> None:
        self.root, self.parse = root, parse
        self.found: list[Diagnostic] = []
        self.values = self.files = 0
        self.parsed: dict[FilePath, Parsed] = {}
        self.alone: set[FilePath] = set()  # files whose text names no other

    def program(self, file: FilePath, asked: Location, within: tuple[FilePath, ...]) -> Tree:
        """A file at the root of the program: its sections may stand under `definition`."""
        tree, target = self._file(file, asked, within)
        inside = (*within, target)
        if not isinstance(tree, Block):
            return self.expand(tree, target, inside)
        own = Block({k: i for k, i in tree.items.items() if k != INCLUDE}, tree.at)
        over = _lifted(self.expand(own, target, inside), self.found)
        bases = [self._included(name, target, inside, top=True) for name in self._names(tree)]
        return self._layered(bases, over)

    def expand(self, tree: Tree, file: FilePath, within: tuple[FilePath, ...]) -> Tree:
        """`tree` of `file` with all includes below it put in; rules for lists stay where they may meet a base."""
        if isinstance(tree, Scalar) or file in self.alone:
            return tree
        if isinstance(tree, Row):
            return Row(tuple(self.expand(item, file, within) for item in tree.items), tree.at)
        items = {k: Item(i.at, self.expand(i.value, file, within)) for k, i in tree.items.items() if k != INCLUDE}
        own = Block(items, tree.at)
        if INCLUDE not in tree.items:
            return own
        return self._layered([self._included(name, file, within) for name in self._names(tree)], own)

    def _layered(self, bases: list[Tree | None], over: Tree) -> Tree:
        """Bases from the lowest up, then `over`; one that is absent was already reported."""
        there = [base for base in bases if base is not None]
        if not there:
            return over
        below = settled(there[0], self.found)
        for layer in there[1:]:
            below = merge(below, layer, self.found)
        return below if isinstance(over, Block) and not over.items else merge(below, over, self.found)

    def _names(self, tree: Block) -> list[Scalar]:
        item = tree.items.get(INCLUDE)
        if item is None:
            return []
        names = item.value.items if isinstance(item.value, Row) else (item.value,)
        texts = [name for name in names if isinstance(name, Scalar) and isinstance(name.value, str)]
        if len(texts) < len(names):
            self.found.append(
                finding("scene/invalid-value", "`include` takes a path or a list of paths", where=item.at)
            )
        return texts

    def _included(self, name: Scalar, file: FilePath, within: tuple[FilePath, ...], top: bool = False) -> Tree | None:
        try:
            if top:
                return self.program(file.parent / name.text, name.at, within)
            tree, target = self._file(file.parent / name.text, name.at, within)
            return self.expand(tree, target, (*within, target))
        except InvalidInput as error:
            if error.diagnostic.code == "scene/file-too-large":
                raise  # What is too large is not read on.
            self.found.append(error.diagnostic)
            return None

    def _file(self, file: FilePath, asked: Location, within: tuple[FilePath, ...]) -> tuple[Tree, FilePath]:
        """The tree of one file and its resolved path. Raises InvalidInput."""
        try:
            target = file.resolve()
            if not target.is_relative_to(self.root):
                raise InvalidInput(finding("scene/path-escape", f"{file.name} lies outside the root", where=asked))
            name = target.relative_to(self.root).as_posix()
            if target in within:
                chain = [f.relative_to(self.root).as_posix() for f in within[within.index(target) :]]
                labels = tuple(Label(where=Location(file=one), text="in the circle") for one in chain)
                headline = f"{name} includes itself: {' -> '.join([*chain, name])}"
                raise InvalidInput(finding("scene/include-cycle", headline, where=asked, labels=labels))
            data = b"" if target in self.parsed else target.read_bytes()
        except (OSError, ValueError, RuntimeError):  # absent, a folder, a name that no file can have, a circle of links
            raise InvalidInput(finding("scene/missing-file", f"cannot read {file.name}", where=asked)) from None
        self.files += 1
        if self.files > MAX_FILES:
            raise too_large("the program includes too many files", asked, None, MAX_FILES, "files")
        if target not in self.parsed:
            self.parsed[target] = self.parse(data, name)
            self.found += self.parsed[target].diagnostics
            if INCLUDE.encode() not in data and b"\\" not in data:  # A key may be written with escapes.
                self.alone.add(target)
        self.values += self.parsed[target].values
        if self.values > MAX_VALUES:
            raise too_large("the program holds too many values", asked, None, MAX_VALUES, "values")
        return self.parsed[target].tree, target


def _lifted(tree: Tree, found: list[Diagnostic]) -> Tree:
    """Sections under `definition` moved up to where they belong; what stands there already lies over them."""
    if not isinstance(tree, Block) or DEFINITION not in tree.items:
        return tree
    definition = tree.items[DEFINITION]
    if not isinstance(definition.value, Block):
        return tree
    sections = {k: i for k, i in definition.value.items.items() if k in SECTIONS}
    facts = Block({k: i for k, i in definition.value.items.items() if k not in SECTIONS}, definition.value.at)
    rest = {k: i for k, i in tree.items.items() if k != DEFINITION}
    both = {
        k: Item(i.at, merge(settled(i.value, found), rest[k].value, found)) for k, i in sections.items() if k in rest
    }
    return Block({**sections, **rest, **both, DEFINITION: Item(definition.at, facts)}, tree.at)
