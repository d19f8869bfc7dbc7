"""Classes of defaults of an MJCF model: attributes by class and element, with those of the classes around.

mujoco.readthedocs.io/en/stable/modeling.html#default-settings.
"""

from __future__ import annotations

from formats.xml_elements import Element, refuse

ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
MAIN = "main"


class Defaults:
    """`attributes(element, inherited)` gives an element's attributes over those of its class."""

    def __init__(self, top: Element) -> None:
        """Raises InvalidInput for a class without a name (`robot/missing-name`) or twice (`robot/duplicate-name`)."""
        self.classes: dict[str, dict[str, dict[str, str]]] = {MAIN: {}}
        self.outermost = {MAIN}
        for element in top.named("default"):
            name = element.get("class", MAIN)
            self.outermost.add(name)
            self._add(self.classes[MAIN], element)
            self.classes[name] = self.classes[MAIN]
            self._nested(element)

    def _nested(self, outer: Element) -> None:
        waiting = [(child, self.classes[MAIN]) for child in reversed(outer.named("default"))]
        while waiting:
            element, around = waiting.pop()
            name = element.get("class")
            if not name:
                refuse("robot/missing-name", "a class of defaults has no name", element.source)
            if name in self.classes:
                refuse("robot/duplicate-name", f"two classes of defaults are called '{name}'", element.source, name)
            by_tag = {tag: dict(attributes) for tag, attributes in around.items()}
            self._add(by_tag, element)
            self.classes[name] = by_tag
            waiting += [(child, by_tag) for child in reversed(element.named("default"))]

    @staticmethod
    def _add(by_tag: dict[str, dict[str, str]], element: Element) -> None:
        for child in element.children:
            if child.tag != "default":
                by_tag[child.tag] = merged(by_tag.get(child.tag, {}), child.attributes)

    def attributes(self, element: Element, inherited: str) -> dict[str, str]:
        """Attributes of an element over those of its class, or of the class `inherited` from the bodies around.

        Raises InvalidInput `robot/unknown-class`.
        """
        name = element.get("class", inherited) or MAIN
        if name not in self.classes:
            refuse("robot/unknown-class", f"the class '{name}' is not defined", element.source, value=name)
        return merged(self.classes[name].get(element.tag, {}), element.attributes)


def merged(outer: dict[str, str], stated: dict[str, str]) -> dict[str, str]:
    """The attributes of both, `stated` first; an orientation replaces one that is written in another way."""
    if any(key in stated for key in ORIENTATIONS):
        outer = {key: value for key, value in outer.items() if key not in ORIENTATIONS}
    return {**outer, **stated}
