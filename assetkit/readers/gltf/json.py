"""A typed view of parsed JSON: a wrong type is `asset/schema-error` with its JSON pointer, never a TypeError."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

from schemas.diagnostics import InvalidInput, Location, finding

_MISSING: Final = object()


@dataclass(frozen=True)
class Json:
    """One JSON value and its place (`pointer` as in RFC 6901). All methods raise InvalidInput on a wrong type."""

    value: Any
    file: str
    pointer: str = ""

    @property
    def where(self) -> Location:
        """This value's place, for diagnostics."""
        return Location(file=self.file, prim=self.pointer or "/")

    def schema_error(self, headline: str) -> InvalidInput:
        """The exception for what is wrong with this value."""
        shown = repr(self.value)
        shown = shown if len(shown) <= 60 else shown[:57] + "..."
        return InvalidInput(finding("asset/schema-error", headline, where=self.where, value=shown))

    def get(self, key: str) -> Json | None:
        """Member `key` of this object, or None when absent."""
        if not isinstance(self.value, dict):
            raise self.schema_error(f"expected an object, found {_type(self.value)}")
        value = self.value.get(key, _MISSING)
        return None if value is _MISSING else self._child(key, value)

    def require(self, key: str) -> Json:
        """Member `key` of this object, which must be there."""
        member = self.get(key)
        if member is None:
            raise self.schema_error(f"'{key}' is missing")
        return member

    def object(self, key: str) -> Json:
        """Member `key`, an object; an empty one when absent."""
        member = self.get(key) or self._child(key, {})
        member.members()
        return member

    def members(self) -> tuple[Json, ...]:
        """The members of this object in file order; `key` holds their names."""
        if not isinstance(self.value, dict):
            raise self.schema_error(f"expected an object, found {_type(self.value)}")
        return tuple(self._child(key, value) for key, value in self.value.items())

    @property
    def key(self) -> str:
        """The member name or array index of this value."""
        return self.pointer.rpartition("/")[2].replace("~1", "/").replace("~0", "~")

    def items(self, key: str) -> tuple[Json, ...]:
        """The elements of array member `key`; none when absent."""
        member = self.get(key)
        return () if member is None else member.elements()

    def elements(self) -> tuple[Json, ...]:
        """The elements of this array."""
        if not isinstance(self.value, list):
            raise self.schema_error(f"expected an array, found {_type(self.value)}")
        return tuple(self._child(str(i), value) for i, value in enumerate(self.value))

    def extension(self, name: str) -> Json | None:
        """The object of extension `name` on this object, or None."""
        extension = self.object("extensions").get(name)
        if extension is not None:
            extension.members()
        return extension

    def string(self, key: str, default: str) -> str:
        """Member `key`, a string."""
        member = self.get(key)
        return default if member is None else member.as_string()

    def boolean(self, key: str, default: bool) -> bool:
        """Member `key`, true or false."""
        member = self.get(key)
        if member is None:
            return default
        if not isinstance(member.value, bool):
            raise member.schema_error(f"expected true or false, found {_type(member.value)}")
        return member.value

    def integer(self, key: str, default: int | None = None, *, minimum: int = 0) -> int:
        """Member `key`, an integer not below `minimum`; it must be there when no default is given."""
        member = self.get(key)
        if member is None and default is not None:
            return default
        return (member or self.require(key)).as_integer(minimum)

    def index(self, key: str, array: tuple[Json, ...], name: str) -> int | None:
        """Member `key`, an index into `array` (called `name` in the file), or None when absent."""
        member = self.get(key)
        return None if member is None else member.as_index(array, name)

    def number(self, key: str, default: float) -> float:
        """Member `key`, a finite number."""
        member = self.get(key)
        return default if member is None else member.as_number()

    def vector(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Member `key`, an array of as many finite numbers as `default` has."""
        member = self.get(key)
        if member is None:
            return default
        elements = member.elements()
        if len(elements) != len(default):
            raise member.schema_error(f"expected {len(default)} numbers, found {len(elements)}")
        return tuple(e.as_number() for e in elements)

    def as_string(self) -> str:
        """This value, a string."""
        if not isinstance(self.value, str):
            raise self.schema_error(f"expected a string, found {_type(self.value)}")
        return self.value

    def as_number(self) -> float:
        """This value, a finite number."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            raise self.schema_error(f"expected a number, found {_type(self.value)}")
        if not abs(self.value) <= _LARGEST:
            raise self.schema_error("the number is not finite")
        return float(self.value)

    def as_integer(self, minimum: int = 0) -> int:
        """This value, an integer not below `minimum`."""
        number = self.as_number()
        if not number.is_integer() or number < minimum:
            raise self.schema_error(f"expected an integer of at least {minimum}")
        return int(self.value)

    def as_index(self, array: tuple[Json, ...], name: str) -> int:
        """This value, an index into `array` (called `name` in the file)."""
        index = self.as_integer()
        if index >= len(array):
            raise self.schema_error(f"'{name}' has {len(array)} elements; there is no element {index}")
        return index

    def _child(self, key: str, value: Any) -> Json:
        return Json(value, self.file, f"{self.pointer}/{key.replace('~', '~0').replace('/', '~1')}")


_LARGEST: Final = math.nextafter(math.inf, 0.0)
_TYPES: Final = {dict: "an object", list: "an array", str: "a string", bool: "true or false", type(None): "null"}


def _type(value: Any) -> str:
    return _TYPES.get(type(value), "a number")
