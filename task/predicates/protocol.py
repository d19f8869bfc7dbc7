"""What every predicate is: a model of its parameters that turns rows of a state log into truth values.

Most predicates look at one frame (`Instant`). Others remember: they begin with `start()` when their node becomes active
and carry what they know from rows to rows, so that a log judged in one piece, in any pieces, or frame by frame gives
the same values.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, cast

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, SerializeAsAny
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames

ROLE = "role"  # mark of a field that names an object, or several
CHANNELS = ("poses", "joints", "contacts", "grippers", "volumes", "surfaces", "attributes", "home")


class Predicate(BaseModel, ABC):
    """A condition with its parameters. `needs` are the channels of `CHANNELS` that it reads."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    func: ClassVar[str]
    needs: ClassVar[frozenset[str]] = frozenset({"poses"})
    instant: ClassVar[bool] = False  # whether a frame alone decides

    def start(self) -> Any:
        """What it knows before the first row."""
        return None

    @abstractmethod
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        """(n,) truth in each row, and what to carry to the next rows. Raises StateMissing."""

    def parts(self) -> Iterator[Predicate]:
        """This predicate and all that it consists of."""
        yield self
        for name in type(self).model_fields:
            for part in items(getattr(self, name)):
                if isinstance(part, Predicate):
                    yield from part.parts()

    def objects(self) -> Iterator[str]:
        """Names of all objects that it and its parts read."""
        for part in self.parts():
            for name, field in type(part).model_fields.items():
                if ROLE in field.metadata:
                    yield from (str(item) for item in items(getattr(part, name)))

    def written(self) -> dict[str, Any]:
        """As a program writes it: `_func` and the parameters that are no defaults, conditions within it too."""
        parameters: dict[str, Any] = {"_func": self.func}
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if value == field.default:
                continue
            plain = [item.written() if isinstance(item, Predicate) else item for item in items(value)]
            parameters[name] = plain if isinstance(value, tuple) else plain[0]
        return parameters

    def channels(self) -> frozenset[str]:
        """Everything that it and its parts read."""
        return frozenset[str]().union(*(part.needs for part in self.parts()))


class Instant(Predicate):
    """A predicate that a frame decides, alone or with the first one of the episode."""

    instant: ClassVar[bool] = True

    @abstractmethod
    def holds(self, frames: Frames) -> BoolArray:
        """(n,) whether it holds in each row. Raises StateMissing."""

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        return self.holds(frames), carry


def _nested(value: object) -> object:
    """A predicate written inside another: a mapping with `_func`."""
    from task.predicates.table import predicate_from

    return predicate_from(cast(dict[str, Any], value)) if isinstance(value, dict) else value


def _some(names: tuple[str, ...]) -> tuple[str, ...]:
    if not names:
        raise ValueError("needs at least one object")
    return names


def items(value: object) -> tuple[object, ...]:
    """The entries of a field that is one value or a tuple of them."""
    return cast(tuple[object, ...], value) if isinstance(value, tuple) else (value,)


Object = Annotated[str, Field(description="an object by its name, or `@tag` for the one with this tag"), ROLE]
Objects = Annotated[tuple[str, ...], AfterValidator(_some), Field(description="objects by name or tag"), ROLE]
Part = Annotated[SerializeAsAny[Predicate], BeforeValidator(_nested)]
Metres = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Seconds = Annotated[float, Field(gt=0.0)]
Radians = Annotated[float, Field(ge=0.0, le=3.1415926535897936)]
