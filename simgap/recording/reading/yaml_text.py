"""Reads YAML as plain values with their line and column, so that a finding can point at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from schemas.diagnostics import InvalidInput, Location, finding

MAX_YAML_BYTES = 1_000_000


@dataclass(frozen=True)
class YamlDocument:
    """Plain values and the syntax tree they came from."""

    file: str
    value: Any
    tree: Node | None

    def place(self, path: Sequence[str | int] = (), *, of_key: bool = False) -> Location:
        """Where the value at `path` begins (its key with `of_key`), or the deepest part of the path that exists."""
        node, mark = self.tree, self.tree.start_mark if self.tree is not None else None
        for step in path:
            key, child = _child(node, step)
            if child is None:
                break
            node, mark = child, (key or child).start_mark if of_key else child.start_mark
        if mark is None:
            return Location(file=self.file, line=1, column=1)
        return Location(file=self.file, line=mark.line + 1, column=mark.column + 1)

    def texts(self, path: Sequence[str | int]) -> list[str] | None:
        """The list of scalars at `path` as they are written (`007` stays `007`), None where no such list is."""
        node = self.tree
        for step in path:
            _, node = _child(node, step)
        if not isinstance(node, SequenceNode) or not all(isinstance(n, ScalarNode) for n in node.value):
            return None
        return [n.value for n in node.value]


def parse_yaml(data: bytes, file: str) -> YamlDocument:
    """YAML 1.2 without tags; `file` is how findings call it.

    Raises InvalidInput (`gap/yaml-syntax`, `gap/file-too-large`).
    """
    if len(data) > MAX_YAML_BYTES:
        raise InvalidInput(
            finding(
                "gap/file-too-large",
                f"{file} has {len(data)} bytes",
                where=Location(file=file),
                value=len(data),
                bound=MAX_YAML_BYTES,
                unit="bytes",
            )
        )
    try:
        text = data.decode("utf-8-sig")
        tree = YAML(typ="safe", pure=True).compose(text)
        return YamlDocument(file, YAML(typ="safe", pure=True).load(text), tree)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = Location(file=file, line=mark.line + 1, column=mark.column + 1) if mark else Location(file=file)
        problem = error.problem or error.context or "unreadable"
    except UnicodeDecodeError as error:
        where, problem = Location(file=file, line=data[: error.start].count(b"\n") + 1), "the text is not UTF-8"
    except (YAMLError, RecursionError, ValueError, LookupError, AttributeError) as error:  # some of odd directives
        where = Location(file=file)
        words = (str(error).splitlines() or [type(error).__name__])[0]
        problem = "nested too deeply" if isinstance(error, RecursionError) else words
    raise InvalidInput(finding("gap/yaml-syntax", problem, where=where))


def _child(node: Node | None, step: str | int) -> tuple[Node | None, Node | None]:
    """Key and value node below `node`."""
    if isinstance(node, MappingNode):
        for key, value in node.value:
            if key.value == str(step):
                return key, value
    if isinstance(node, SequenceNode) and isinstance(step, int) and step < len(node.value):
        return None, node.value[step]
    return None, None
