"""An overlay over its base: fields override fields, lists follow explicit rules.

Over a list a list replaces; a mapping works on it: `$replace: [...]`, `$append: [...]`, and any other key is the id of
an item that the value is merged into. `$delete: true` removes the key or item that it stands for. A mapping whose
`type` changes replaces the base, because its other keys belong to another kind of thing.
"""

from __future__ import annotations

from scenec.source.hint import did_you_mean
from scenec.source.tree import Block, Item, Row, Scalar, Tree, child
from schemas.diagnostics import Diagnostic, Location, finding

APPEND, REPLACE, DELETE = "$append", "$replace", "$delete"


def merge(base: Tree, over: Tree, found: list[Diagnostic]) -> Tree:
    """`over` laid over `base`, which holds no rules any more; what rules cannot do is added to `found`."""
    if isinstance(base, Row) and isinstance(over, Block):
        return _edited(base, over, found)
    if not (isinstance(base, Block) and isinstance(over, Block)) or _type_changes(base, over):
        return settled(over, found)
    items = dict(base.items)
    for key, item in over.items.items():
        if _deletes(item.value):
            if items.pop(key, None) is None:
                found.append(_nothing(f"`{key}` is not in what this overrides", item.at, key, list(base.items)))
        elif key in items:
            value = merge(items[key].value, item.value, found)
            replaced = value.at != items[key].value.at
            items[key] = Item(item.at if replaced else items[key].at, value)
        else:
            items[key] = Item(item.at, settled(item.value, found))
    return Block(items, base.at)


def settled(tree: Tree, found: list[Diagnostic]) -> Tree:
    """The tree where it lies over nothing: a list to append to is empty, and there is nothing to delete. What holds no
    rules is handed back as it is."""
    if isinstance(tree, Scalar) or not tree.has_rules:
        return tree
    if isinstance(tree, Row):
        return Row(tuple(settled(item, found) for item in tree.items), tree.at)
    if tree.items and set(tree.items) <= {APPEND, REPLACE}:
        return _edited(Row((), tree.at), tree, found)
    items: dict[str, Item] = {}
    for key, item in tree.items.items():
        if _deletes(item.value):
            found.append(_nothing(f"there is no `{key}` to delete", item.at, key, []))
        elif key in (APPEND, REPLACE, DELETE):
            found.append(_nothing(f"`{key}` stands over no list or key", item.at, key, []))
        else:
            items[key] = Item(item.at, settled(item.value, found))
    return Block(items, tree.at)


def _edited(base: Row, over: Block, found: list[Diagnostic]) -> Row:
    """A list after the rules of `over`, in this order: replace, by id, append."""
    replacement = over.items.get(REPLACE)
    left = _list(replacement, found) if replacement else list(base.items)
    for key, item in over.items.items():
        if key in (APPEND, REPLACE):
            continue
        ids = [_id(entry) for entry in left]
        if key not in ids:
            known = [i for i in ids if i is not None]
            found.append(_nothing(f"no item of the list below this has the id `{key}`", item.at, key, known))
        elif _deletes(item.value):
            left = [entry for entry, i in zip(left, ids, strict=True) if i != key]
        else:
            at = ids.index(key)
            left[at] = merge(left[at], item.value, found)
    more = over.items.get(APPEND)
    return Row((*left, *(_list(more, found) if more else [])), base.at)


def _list(item: Item, found: list[Diagnostic]) -> list[Tree]:
    if not isinstance(item.value, Row):
        found.append(finding("scene/bad-overlay", "`$append` and `$replace` take a list", where=item.at))
        return []
    return [settled(entry, found) for entry in item.value.items]


def _id(entry: Tree) -> str | None:
    """What an item of a list is called: its `id`, or itself where it is a single value."""
    if isinstance(entry, Scalar):
        return entry.text
    named = child(entry, ("id",))
    return named.text if isinstance(named, Scalar) else None


def _deletes(tree: Tree) -> bool:
    if not isinstance(tree, Block) or DELETE not in tree.items:
        return False
    mark = tree.items[DELETE].value
    return isinstance(mark, Scalar) and mark.value is True


def _type_changes(base: Block, over: Block) -> bool:
    old, new = child(base, ("type",)), child(over, ("type",))
    return isinstance(old, Scalar) and isinstance(new, Scalar) and old.text != new.text


def _nothing(headline: str, where: Location, name: str, known: list[str]) -> Diagnostic:
    return finding("scene/bad-overlay", headline + did_you_mean(name, known), where=where)
