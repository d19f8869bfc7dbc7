"""Loads the files of a program into one tree: `include` at any node, and sections under `definition`.

`include: file.yaml` in a mapping inserts that file there, then merges the other keys of the mapping over it; of a list
of files each is merged over those before it. Paths are relative to the including file, or else to the root folder, and
stay inside the root folder.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as FilePath

from schemas.diagnostics import Diagnostic, InvalidInput, Label, Location, finding
from schemas.files.regular_file import read_regular
from source.merge import merge, resolve_overlays
from source.parse import MAX_VALUES, Parsed, parse, too_large
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping

MAX_FILES = 1000  # every inclusion counts, also of the same file
INCLUDE, DEFINITION = "include", "definition"
Parse = Callable[[bytes, str], Parsed]


def load(
    file: FilePath, root: FilePath, parse: Parse = parse, *, sections: frozenset[str] = frozenset()
) -> tuple[Tree | None, tuple[Diagnostic, ...]]:
    """The whole program whose first file is `file`, None when that cannot be read, and all findings.

    Findings name files relative to `root`, which must be resolved. `sections` are the keys that may also stand under
    `definition`.
    """
    loader = _Loader(root, parse, sections)
    try:
        tree: Tree | None = loader.program(file, Location(file=file.name), ())
    except InvalidInput as error:
        loader.diagnostics.append(error.diagnostic)
        tree = None
    return tree, tuple(loader.diagnostics)


def read_tree(
    file: FilePath, root: FilePath, parse: Parse = parse, *, sections: frozenset[str] = frozenset()
) -> tuple[Tree | None, tuple[Diagnostic, ...]]:
    """As `load`, with the overlay rules that are left resolved over nothing, as in a file that no other includes."""
    tree, diagnostics = load(file, root, parse, sections=sections)
    if tree is None:
        return None, diagnostics
    rules: list[Diagnostic] = []
    tree = resolve_overlays(tree, rules)
    return tree, (*diagnostics, *rules)


class _Loader:
    def __init__(self, root: FilePath, parse: Parse, sections: frozenset[str]) -> None:
        self.root, self.parse, self.sections = root, parse, sections
        self.diagnostics: list[Diagnostic] = []
        self.values = self.files = 0
        self.parsed: dict[FilePath, Parsed] = {}
        self.alone: set[FilePath] = set()  # files without `include`

    def program(self, file: FilePath, referrer: Location, within: tuple[FilePath, ...]) -> Tree:
        """A file at the root of the program: its sections may stand under `definition`."""
        tree, target = self._file(file, referrer, within)
        inside = (*within, target)
        if not isinstance(tree, TreeMapping):
            return self.expand(tree, target, inside)
        block = TreeMapping({k: i for k, i in tree.items.items() if k != INCLUDE}, tree.at)
        over = lift_definition(self.expand(block, target, inside), self.sections, self.diagnostics)
        bases = [self._included(name, target, inside, top=True) for name in self._names(tree)]
        return self._layered(bases, over)

    def expand(self, tree: Tree, file: FilePath, within: tuple[FilePath, ...]) -> Tree:
        """`tree` of `file` with all includes below it expanded; overlay rules stay where a base may still come."""
        if isinstance(tree, Scalar) or file in self.alone:
            return tree
        if isinstance(tree, TreeList):
            return TreeList(tuple(self.expand(item, file, within) for item in tree.items), tree.at)
        items = {k: TreeEntry(i.at, self.expand(i.value, file, within)) for k, i in tree.items.items() if k != INCLUDE}
        block = TreeMapping(items, tree.at)
        if INCLUDE not in tree.items:
            return block
        return self._layered([self._included(name, file, within) for name in self._names(tree)], block)

    def _layered(self, bases: list[Tree | None], over: Tree) -> Tree:
        """Bases merged from the first on, then `over`; a missing one was already reported."""
        there = [base for base in bases if base is not None]
        if not there:
            return over
        below = resolve_overlays(there[0], self.diagnostics)
        for layer in there[1:]:
            below = merge(below, layer, self.diagnostics)
        return below if isinstance(over, TreeMapping) and not over.items else merge(below, over, self.diagnostics)

    def _names(self, tree: TreeMapping) -> list[Scalar]:
        item = tree.items.get(INCLUDE)
        if item is None:
            return []
        names = item.value.items if isinstance(item.value, TreeList) else (item.value,)
        texts = [name for name in names if isinstance(name, Scalar) and isinstance(name.value, str)]
        if len(texts) < len(names):
            self.diagnostics.append(
                finding("scene/invalid-value", "`include` takes a path or a list of paths", where=item.at)
            )
        return texts

    def _included(self, name: Scalar, file: FilePath, within: tuple[FilePath, ...], top: bool = False) -> Tree | None:
        try:
            if top:
                return self.program(self._beside(file, name), name.at, within)
            tree, target = self._file(self._beside(file, name), name.at, within)
            return self.expand(tree, target, (*within, target))
        except InvalidInput as error:
            if error.diagnostic.code == "scene/file-too-large":
                raise  # A program that is too large is not read further.
            self.diagnostics.append(error.diagnostic)
            return None

    def _beside(self, file: FilePath, name: Scalar) -> FilePath:
        """The file of a name: beside the including file, or else below the root."""
        beside, below = file.parent / name.text, self.root / name.text
        try:
            return below if not beside.exists() and below.exists() else beside
        except (OSError, ValueError):  # a name that no file can have
            return beside

    def _file(self, file: FilePath, referrer: Location, within: tuple[FilePath, ...]) -> tuple[Tree, FilePath]:
        """The tree of one file and its resolved path. Raises InvalidInput."""
        try:
            target = file.resolve()
            if not target.is_relative_to(self.root):
                raise InvalidInput(finding("scene/path-escape", f"{file.name} lies outside the root", where=referrer))
            name = target.relative_to(self.root).as_posix()
            if target in within:
                chain = [f.relative_to(self.root).as_posix() for f in within[within.index(target) :]]
                labels = tuple(Label(where=Location(file=one), text="in the circle") for one in chain)
                headline = f"{name} includes itself: {' -> '.join([*chain, name])}"
                raise InvalidInput(finding("scene/include-cycle", headline, where=referrer, labels=labels))
            data = b"" if target in self.parsed else read_regular(target)
        except (OSError, ValueError, RuntimeError):  # absent, a folder, a name that no file can have, a circle of links
            raise InvalidInput(finding("scene/missing-file", f"cannot read {file.name}", where=referrer)) from None
        self.files += 1
        if self.files > MAX_FILES:
            raise too_large("the program includes too many files", referrer, None, MAX_FILES, "files")
        if target not in self.parsed:
            self.parsed[target] = self.parse(data, name)
            self.diagnostics += self.parsed[target].diagnostics
            if INCLUDE.encode() not in data and b"\\" not in data:  # A key may be written with escapes.
                self.alone.add(target)
        self.values += self.parsed[target].values
        if self.values > MAX_VALUES:
            raise too_large("the program holds too many values", referrer, None, MAX_VALUES, "values")
        return self.parsed[target].tree, target


def lift_definition(tree: Tree, sections: frozenset[str], diagnostics: list[Diagnostic]) -> Tree:
    """Those sections under `definition` moved to the top level, where existing ones are merged over them."""
    if not isinstance(tree, TreeMapping) or DEFINITION not in tree.items:
        return tree
    definition = tree.items[DEFINITION]
    if not isinstance(definition.value, TreeMapping):
        return tree
    lifted = {k: i for k, i in definition.value.items.items() if k in sections}
    facts = TreeMapping({k: i for k, i in definition.value.items.items() if k not in sections}, definition.value.at)
    rest = {k: i for k, i in tree.items.items() if k != DEFINITION}
    both = {
        k: TreeEntry(i.at, merge(resolve_overlays(i.value, diagnostics), rest[k].value, diagnostics))
        for k, i in lifted.items()
        if k in rest
    }
    return TreeMapping({**lifted, **rest, **both, DEFINITION: TreeEntry(definition.at, facts)}, tree.at)
