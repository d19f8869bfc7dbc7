"""Merges an overlay over its base: fields override fields, lists follow explicit rules.

A list over a list replaces it. A mapping over a list edits it: `$replace: [...]`, `$append: [...]`, and any other key
is the id of an item that the value is merged into. `$delete: true` removes its key or item. A mapping whose `type`
changes replaces the base, because the other keys belong to another type.
"""

from __future__ import annotations

from schemas.diagnostics import Diagnostic, Location, finding
from source.hint import did_you_mean
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping, child

APPEND, REPLACE, DELETE = "$append", "$replace", "$delete"


def merge(base: Tree, over: Tree, diagnostics: list[Diagnostic]) -> Tree:
    """`over` merged over `base`, which has no unresolved rules; rules that cannot apply add to `diagnostics`."""
    if isinstance(base, TreeList) and isinstance(over, TreeMapping):
        return _edited(base, over, diagnostics)
    if not (isinstance(base, TreeMapping) and isinstance(over, TreeMapping)) or _type_changes(base, over):
        return resolve_overlays(over, diagnostics)
    items = dict(base.items)
    for key, item in over.items.items():
        if _deletes(item.value):
            if items.pop(key, None) is None:
                diagnostics.append(_nothing(f"`{key}` is not in what this overrides", item.at, key, list(base.items)))
        elif key in items:
            value = merge(items[key].value, item.value, diagnostics)
            replaced = value.at != items[key].value.at
            items[key] = TreeEntry(item.at if replaced else items[key].at, value)
        else:
            items[key] = TreeEntry(item.at, resolve_overlays(item.value, diagnostics))
    return TreeMapping(items, base.at)


def resolve_overlays(tree: Tree, diagnostics: list[Diagnostic]) -> Tree:
    """The tree merged over nothing: `$append` extends an empty list, and there is nothing to `$delete`. A tree without
    rules is returned unchanged."""
    if isinstance(tree, Scalar) or not tree.has_overlay_rules:
        return tree
    if isinstance(tree, TreeList):
        return TreeList(tuple(resolve_overlays(item, diagnostics) for item in tree.items), tree.at)
    if tree.items and set(tree.items) <= {APPEND, REPLACE}:
        return _edited(TreeList((), tree.at), tree, diagnostics)
    items: dict[str, TreeEntry] = {}
    for key, item in tree.items.items():
        if _deletes(item.value):
            diagnostics.append(_nothing(f"there is no `{key}` to delete", item.at, key, []))
        elif key in (APPEND, REPLACE, DELETE):
            diagnostics.append(_nothing(f"`{key}` stands over no list or key", item.at, key, []))
        else:
            items[key] = TreeEntry(item.at, resolve_overlays(item.value, diagnostics))
    return TreeMapping(items, tree.at)


def _edited(base: TreeList, over: TreeMapping, diagnostics: list[Diagnostic]) -> TreeList:
    """A list edited by the rules of `over`, in this order: `$replace`, items by id, `$append`."""
    replacement = over.items.get(REPLACE)
    left = _list(replacement, diagnostics) if replacement else list(base.items)
    for key, item in over.items.items():
        if key in (APPEND, REPLACE):
            continue
        ids = [_id(entry) for entry in left]
        if key not in ids:
            known = [i for i in ids if i is not None]
            diagnostics.append(_nothing(f"no item of the list below this has the id `{key}`", item.at, key, known))
        elif _deletes(item.value):
            left = [entry for entry, i in zip(left, ids, strict=True) if i != key]
        else:
            at = ids.index(key)
            left[at] = merge(left[at], item.value, diagnostics)
    more = over.items.get(APPEND)
    return TreeList((*left, *(_list(more, diagnostics) if more else [])), base.at)


def _list(item: TreeEntry, diagnostics: list[Diagnostic]) -> list[Tree]:
    if not isinstance(item.value, TreeList):
        diagnostics.append(finding("scene/bad-overlay", "`$append` and `$replace` take a list", where=item.at))
        return []
    return [resolve_overlays(entry, diagnostics) for entry in item.value.items]


def _id(entry: Tree) -> str | None:
    """The id of an item of a list: its `id`, or its own text where it is a scalar."""
    if isinstance(entry, Scalar):
        return entry.text
    named = child(entry, ("id",))
    return named.text if isinstance(named, Scalar) else None


def _deletes(tree: Tree) -> bool:
    if not isinstance(tree, TreeMapping) or DELETE not in tree.items:
        return False
    mark = tree.items[DELETE].value
    return isinstance(mark, Scalar) and mark.value is True


def _type_changes(base: TreeMapping, over: TreeMapping) -> bool:
    old, new = child(base, ("type",)), child(over, ("type",))
    return isinstance(old, Scalar) and isinstance(new, Scalar) and old.text != new.text


def _nothing(headline: str, where: Location, name: str, known: list[str]) -> Diagnostic:
    return finding("scene/bad-overlay", headline + did_you_mean(name, known), where=where)
